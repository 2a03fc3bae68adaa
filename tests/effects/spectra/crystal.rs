//! A cut crystal: it spreads a lamp where Snell's law through its facets puts each wavelength.

use super::glass::narrow_lamp;
use super::rendered;
use glam::{DVec2, DVec3};
use petzval_image::Picture;
use petzval_spectrum::{colour_matching, named_spectrum, srgb_from_xyz};

/// Width and height of the whole picture (pixels), and its field of view (degrees).
const PIXELS: f64 = 200.0;
const FOV: f64 = 4.0;
/// Width and height of the rendered part (pixels).
const CROP: usize = 16;
/// Distance of the lamp, so far away that it is a point, and its radius.
const LAMP: [f64; 2] = [1e6, 900.0];

/// A facet of a crystal: its corners, in order around the outward normal.
struct Facet(Vec<DVec3>);

impl Facet {
    fn normal(&self) -> DVec3 {
        (self.0[1] - self.0[0]).cross(self.0[2] - self.0[0]).normalize()
    }
}

/// An octagonal table and eight facets behind it that meet in a point, turned a little in all directions.
fn crystal() -> Vec<Facet> {
    let slope = 52.0f64.to_radians().tan();
    let place = |p: DVec3| {
        let turn = glam::DQuat::from_euler(glam::EulerRot::ZXY, 0.12, 0.02, 0.015);
        DVec3::new(-0.45, 0.02, 5.0) + turn * p
    };
    let corner = |i: usize| {
        let angle = (i as f64 + 0.5) * std::f64::consts::FRAC_PI_4;
        place(DVec3::new(angle.cos(), angle.sin(), 0.0))
    };
    let tip = place(DVec3::new(0.0, 0.0, slope * std::f64::consts::FRAC_PI_8.cos()));
    let table = Facet((0..8).rev().map(corner).collect());
    let behind = (0..8).map(|i| Facet(vec![corner(i), corner((i + 1) % 8), tip]));
    [table].into_iter().chain(behind).collect()
}

/// Refracts a direction at a surface whose normal is against it; `None` at total internal reflection.
fn refract(direction: DVec3, normal: DVec3, ratio: f64) -> Option<DVec3> {
    let cos = -direction.dot(normal);
    let square = 1.0 - ratio * ratio * (1.0 - cos * cos);
    (square > 0.0).then(|| ratio * direction + (ratio * cos - square.sqrt()) * normal)
}

/// Returns the direction in which a ray from the camera leaves the crystal, and how often it was reflected inside.
fn through(crystal: &[Facet], place: DVec2, index: f64) -> (DVec3, usize) {
    let mut direction = DVec3::new(place.x, place.y, 1.0).normalize();
    let distance = |point: DVec3, direction: DVec3, facet: &Facet| {
        (facet.0[0] - point).dot(facet.normal()) / direction.dot(facet.normal())
    };
    let mut point = distance(DVec3::ZERO, direction, &crystal[0]) * direction;
    direction = refract(direction, crystal[0].normal(), 1.0 / index).expect("into the glass");
    for reflections in 0..10 {
        // The nearest facet ahead: the crystal is convex.
        let ahead = crystal.iter().filter(|facet| direction.dot(facet.normal()) > 1e-9);
        let facet = ahead
            .min_by(|a, b| distance(point, direction, a).total_cmp(&distance(point, direction, b)))
            .expect("a facet");
        point += distance(point, direction, facet) * direction;
        let normal = facet.normal();
        match refract(direction, -normal, index) {
            Some(out) => return (out, reflections),
            None => direction -= 2.0 * direction.dot(normal) * normal,
        }
    }
    panic!("light is trapped")
}

/// Returns the place in the picture, as slopes from the middle, at which light from a direction is seen that is
/// reflected once inside, by Newton's method.
fn seen(crystal: &[Facet], lamp: DVec3, index: f64) -> DVec2 {
    let (side, up) = lamp.any_orthonormal_pair();
    let off = |place: DVec2| {
        let (out, reflections) = through(crystal, place, index);
        assert_eq!(reflections, 1);
        DVec2::new(out.dot(side), out.dot(up))
    };
    let mut place = DVec2::ZERO;
    for _ in 0..30 {
        let (here, step) = (off(place), 1e-6);
        let slope = |axis: DVec2| (off(place + step * axis) - here) / step;
        place -= glam::DMat2::from_cols(slope(DVec2::X), slope(DVec2::Y)).inverse() * here;
    }
    assert!(off(place).length() < 1e-9);
    place
}

/// Returns the column and the row of a place, from the corner of the picture (pixels).
fn pixel(place: DVec2) -> DVec2 {
    let half = (FOV / 2.0).to_radians().tan();
    PIXELS / 2.0 * (DVec2::ONE + DVec2::new(place.x, -place.y) / half)
}

/// Renders the part of the picture around a place, for a lamp in a direction.
fn rendered_around(
    centre: DVec2,
    crystal: &[Facet],
    direction: DVec3,
    lamp: &str,
    samples: u32,
) -> (DVec2, Picture) {
    let low = centre.round() - DVec2::splat(CROP as f64 / 2.0);
    let high = low + DVec2::splat(CROP as f64);
    let position = LAMP[0] * direction;
    let (mut points, mut indices, mut count) = (String::new(), String::new(), 0);
    for Facet(corners) in crystal {
        for p in corners {
            points += &format!("{} {} {}  ", p.x, p.y, p.z);
        }
        for i in 2..corners.len() {
            indices += &format!("{count} {} {}  ", count + i - 1, count + i);
        }
        count += corners.len();
    }
    let scene = format!(
        "Film \"rgb\" \"integer xresolution\" {PIXELS} \"integer yresolution\" {PIXELS}
         \"integer pixelbounds\" [{} {} {} {}] PixelFilter \"box\"
         Integrator \"path\" \"integer maxdepth\" 6 Camera \"perspective\" \"float fov\" {FOV}
         WorldBegin AttributeBegin AreaLightSource \"diffuse\" {lamp} \"float scale\" 1000
         Translate {} {} {} Shape \"sphere\" \"float radius\" {} AttributeEnd
         Material \"dielectric\" \"spectrum eta\" \"glass-SF11\"
         Shape \"trianglemesh\" \"point3 P\" [{points}] \"integer indices\" [{indices}]",
        low.x, high.x, low.y, high.y, position.x, position.y, position.z, LAMP[1]
    );
    (low, rendered(&scene, samples, "+spectra"))
}

#[test]
fn a_cut_crystal_spreads_a_lamp_where_snell_puts_it() {
    let crystal = crystal();
    let glass = named_spectrum("glass-SF11").expect("a glass");
    let lamp = through(&crystal, DVec2::ZERO, glass.index_at(550.0)).0;
    let place = |nm: f64| pixel(seen(&crystal, lamp, glass.index_at(nm)));
    let strength = |rgb: [f64; 3]| rgb.iter().map(|c| c.abs()).sum::<f64>();
    let colours = [450.0, 550.0, 640.0];
    for nm in colours {
        let (parameter, light) = narrow_lamp(nm);
        let (low, found) = rendered_around(place(nm), &crystal, lamp, &parameter, 16_384);
        let (mut sum, mut moment) = (0.0, DVec2::ZERO);
        for (i, pixel) in found.pixels.iter().enumerate() {
            let seen = strength(pixel.map(f64::from));
            sum += seen;
            moment += seen * (low + DVec2::new((i % CROP) as f64, (i / CROP) as f64) + 0.5);
        }
        let (mut whole, mut expected) = (0.0, DVec2::ZERO);
        for i in 0..80 {
            let at = nm - 3.95 + 0.1 * f64::from(i);
            let weight = light.at(at) * strength(srgb_from_xyz(colour_matching(at)));
            whole += weight;
            expected += weight * place(at);
        }
        let (found, expected) = (moment / sum, expected / whole);
        println!("{nm} nm: {found:.3}, not {expected:.3}");
        assert!((found - expected).length() < 0.1, "{nm} nm: {found}, not {expected}");
    }
    let fan = (place(450.0) - place(640.0)).length();
    assert!(fan > 30.0, "blue and red are {fan} pixels apart");

    // A white lamp shows the colours of the rainbow, each at its place.
    let white = "\"spectrum L\" \"stdillum-D65\"";
    for (nm, channel) in colours.into_iter().zip([2, 1, 0]) {
        let (low, found) = rendered_around(place(nm), &crystal, lamp, white, 1024);
        let at = (place(nm) - low).floor();
        let seen = found.pixels[at.y as usize * CROP + at.x as usize];
        let brightest = (0..3).max_by(|&a, &b| seen[a].total_cmp(&seen[b]));
        assert_eq!(brightest, Some(channel), "{seen:?} at the place of {nm} nm");
    }
}
