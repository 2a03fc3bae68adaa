//! Scalar lens tracer of the textbook, for comparison.
//!
//! It restates, for this benchmark, how pbrt traces its realistic camera (Pharr, Jakob & Humphreys,
//! "Physically Based Rendering", 4th ed., 5.4.1): one ray at a time, each surface intersected
//! through its sphere's centre and a quadratic, the normal normalised and turned against the ray,
//! refraction by the cosines of the directions. z runs from the film (0) to the scene (-z).

use petzval_lens::Prescription;

/// One refracting surface, or the stop.
#[derive(Clone, Copy, Debug)]
pub struct Interface {
    radius: f32,
    z: f32,
    half: f32,
    stop: bool,
    /// Refractive index on the film's side over that on the scene's side.
    ratio: f32,
}

/// A ray: origin and direction.
#[derive(Clone, Copy, Debug)]
pub struct TextbookRay {
    o: [f32; 3],
    d: [f32; 3],
}

impl TextbookRay {
    /// Turns a ray that travels along +z into one that travels along -z.
    pub fn leaving(p: [f32; 3], t: [f32; 3]) -> Self {
        Self { o: [p[0], p[1], 0.0], d: [t[0], t[1], -t[2]] }
    }
}

/// Returns the interfaces of a lens, from the film to the scene; `film` is the distance of the film
/// behind the rear vertex (mm).
pub fn table(lens: &Prescription, film: f64) -> Vec<Interface> {
    let mut z = -film;
    let mut interfaces = Vec::new();
    for i in (0..lens.rows.len()).rev() {
        let row = &lens.rows[i];
        if i + 1 < lens.rows.len() {
            z -= row.thickness;
        }
        interfaces.push(Interface {
            radius: if row.radius.is_infinite() { 0.0 } else { row.radius as f32 },
            z: z as f32,
            half: (row.diameter / 2.0) as f32,
            stop: row.stop,
            ratio: (row.index / lens.index_before(i)) as f32,
        });
    }
    interfaces
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn normalised(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

/// Returns the roots of a quadratic in f32 as pbrt finds them, the smaller first.
fn quadratic(a: f32, b: f32, c: f32) -> Option<[f32; 2]> {
    if a == 0.0 {
        return (b != 0.0).then(|| [-c / b; 2]);
    }
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let q = if b < 0.0 { -0.5 * (b - root) } else { -0.5 * (b + root) };
    let (t0, t1) = (q / a, c / q);
    Some(if t0 > t1 { [t1, t0] } else { [t0, t1] })
}

/// Traces a ray through the lens; `None` if it is blocked.
#[inline(never)]
pub fn trace(interfaces: &[Interface], mut ray: TextbookRay) -> Option<TextbookRay> {
    for interface in interfaces {
        let (t, normal) = if interface.stop {
            ((interface.z - ray.o[2]) / ray.d[2], None)
        } else {
            let centre = interface.z + interface.radius;
            let o = [ray.o[0], ray.o[1], ray.o[2] - centre];
            let a = dot(ray.d, ray.d);
            let b = 2.0 * dot(ray.d, o);
            let c = dot(o, o) - interface.radius * interface.radius;
            let [t0, t1] = quadratic(a, b, c)?;
            let closer = (ray.d[2] > 0.0) ^ (interface.radius < 0.0);
            let t = if closer { t0.min(t1) } else { t0.max(t1) };
            if t < 0.0 {
                return None;
            }
            let n = normalised([0, 1, 2].map(|i| o[i] + t * ray.d[i]));
            let n = if dot(n, ray.d) > 0.0 { n.map(|c| -c) } else { n };
            (t, Some(n))
        };
        let p = [0, 1, 2].map(|i| ray.o[i] + t * ray.d[i]);
        if p[0] * p[0] + p[1] * p[1] > interface.half * interface.half {
            return None;
        }
        ray.o = p;
        if let Some(n) = normal {
            let wi = normalised(ray.d.map(|c| -c));
            let cos = dot(n, wi);
            let sin2 = (1.0 - cos * cos).max(0.0) * interface.ratio * interface.ratio;
            if sin2 >= 1.0 {
                return None;
            }
            let k = interface.ratio * cos - (1.0 - sin2).sqrt();
            ray.d = [0, 1, 2].map(|i| -interface.ratio * wi[i] + k * n[i]);
        }
    }
    Some(ray)
}
