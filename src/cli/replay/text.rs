//! A replayed sample as text.

use std::fmt::Write as _;

use petzval_base::rays::Hit;
use petzval_lens::{BlockReason, Blocked, LensModel, RayPath, SurfaceCrossing};
use petzval_render::job::Job;
use petzval_render::shade::{PathOutcome, SampledLight};
use petzval_render::{Collision, PathStage, PathStep, Replay, ShadowRay};
use petzval_scene::{Geometry, Light};

/// Describes the path of a sample, in lines of at most 100 columns.
pub(super) fn text(job: &Job, replay: &Replay) -> String {
    let ([x, y], breaks) = (replay.name.pixel(), replay.first_non_finite());
    let mut text = Text { lines: String::new(), breaks };
    let (sample, seed) = (replay.name.sample, replay.name.seed);
    text.line("sample", format!("pixel {x},{y}, number {sample}, seed {seed}"));
    let unit = if matches!(job.camera.model, LensModel::Real(_)) { " mm" } else { "" };
    text.line("film", format!("{}{unit}; weight {}", row(&replay.film), number(replay.weight)));
    if let Some(time) = replay.time {
        text.line("time", format!("{} of the motion", number(time)));
    }
    text.light(job, replay);
    match (&replay.ray_path, &job.camera.model) {
        (Some(path), _) => text.lens_path(path),
        (None, LensModel::Real(_)) => text.line("lens", "no light reaches this point of the film"),
        (None, _) => {}
    }
    if let Some((ray, throughput)) = &replay.ray {
        text.line("", "");
        text.line("ray", format!("from {}", row(&ray.origin)));
        text.line("", format!("towards {}", row(&ray.direction)));
        text.line_at(PathStage::Ray, "", format!("throughput {}", row(throughput)));
    }
    replay.steps.iter().enumerate().for_each(|(i, step)| text.step(job, i, step));
    text.line("", "");
    text.line("radiance", row(&replay.radiance));
    match replay.value {
        // All digits, so that the value can be read back.
        Some([r, g, b]) => text.line("adds", format!("{r:e} {g:e} {b:e}")),
        None => text.line("adds", "nothing: the sample is not finite and is dropped"),
    }
    text.buckets(job, replay);
    if job.ghosts.is_some() {
        text.line("", "ghosts add to the pixel too, but belong to no sample");
    }
    if let Some(stage) = breaks {
        text.line("first", format!("{} is not finite", super::describe(stage)));
    }
    text.lines
}

/// Formats a number with about six digits.
fn number(value: impl Into<f64>) -> String {
    let value = value.into();
    match value.abs() {
        size if size == 0.0 || (1e-3..1e6).contains(&size) || !size.is_finite() => {
            format!("{value:.6}")
        }
        _ => format!("{value:.5e}"),
    }
}

fn row(values: &[f32]) -> String {
    values.iter().map(|&value| number(value)).collect::<Vec<_>>().join("  ")
}

struct Text {
    lines: String,
    /// The value to mark as the first that is not finite.
    breaks: Option<PathStage>,
}

impl Text {
    fn line(&mut self, name: &str, text: impl std::fmt::Display) {
        let line = format!("{name:<10}{text}");
        let _ = writeln!(self.lines, "{}", line.trim_end());
    }

    /// Adds a line, marked if its value is the first that is not finite.
    fn line_at(&mut self, stage: PathStage, name: &str, text: String) {
        let mark = if self.breaks == Some(stage) { "   <- not finite" } else { "" };
        self.line(name, text + mark);
    }

    /// Describes the wavelengths of the path and the bands of the light.
    fn light(&mut self, job: &Job, replay: &Replay) {
        if let Some(nm) = replay.wavelengths {
            let nm = nm.map(|nm| format!("{nm:.1}")).join(", ");
            self.line("channels", format!("{nm} nm, in place of red, green and blue"));
        }
        let (Some(band), LensModel::Real(lens)) = (replay.band, &job.camera.model) else { return };
        let (of, wavelength) = (lens.bands.len(), lens.bands[band].wavelength);
        self.line("light", format!("band {} of {of}, {wavelength:.1} nm", band + 1));
        for shared in replay.shared.iter().skip(1) {
            let lands = match shared.reprojection {
                Some((film, share)) => {
                    format!("lands at {} mm, transmitted share {}", row(&film), number(share))
                }
                None => "does not reach the film".to_owned(),
            };
            self.line("", format!("{:.1} nm shares its ray and {lands}", shared.wavelength));
        }
    }

    /// Lists what the sample adds to the buckets of the film that it reaches.
    fn buckets(&mut self, job: &Job, replay: &Replay) {
        let Some(shares) = job.buckets() else { return };
        let middles = shares.buckets().middles();
        for (nm, added) in middles.iter().zip(&replay.buckets).filter(|(_, added)| **added != 0.0) {
            self.line("", format!("{added:e} to the bucket about {nm:.3} nm"));
        }
    }

    /// Describes the path through the lens.
    fn lens_path(&mut self, path: &RayPath) {
        let RayPath { start, direction, weight, retraced, crossings, end } = path;
        let three = |v: &[f64; 3]| v.map(number).join("  ");
        self.line("", "");
        let frame = "mm; z from the front vertex to the film";
        self.line("lens", format!("from {} ({frame})", three(start)));
        self.line("", format!("towards {}; weight {}", three(direction), number(*weight)));
        if *retraced {
            self.line("", "f32 is not exact enough: retraced in f64");
        }
        let head = format!(
            "{:>7}  {:<11}{:>10}{:>10}{:>10}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}",
            "surface", "kind", "x", "y", "z", "height", "clear", "angle", "n", "n'", "passes"
        );
        self.lines += &(head + "\n");
        crossings.iter().for_each(|crossing| self.crossing(crossing));
        if let Err(Blocked { row, reason }) = end {
            let reason = match reason {
                BlockReason::Clip => "outside the clear aperture",
                BlockReason::Stop => "outside the opening of the stop",
                BlockReason::Miss => "it misses the surface",
                BlockReason::Tir => "total reflection",
            };
            self.line("", format!("the ray is blocked at surface {}: {reason}", row + 1));
        }
    }

    fn crossing(&mut self, crossing: &SurfaceCrossing) {
        let SurfaceCrossing {
            row,
            kind,
            point,
            height,
            semi_diameter,
            incidence,
            index: [n, n_behind],
            transmittance,
        } = crossing;
        let fixed = |value: Option<f64>, digits: usize| match value {
            Some(value) => format!("{value:.digits$}"),
            None => "-".to_owned(),
        };
        let [x, y, z] = [0, 1, 2].map(|i| fixed(point.map(|point| point[i]), 4));
        let [height, incidence] = [fixed(*height, 3), fixed(*incidence, 2)];
        let passes = transmittance.map_or("no".to_owned(), |share| format!("{share:.4}"));
        let line = format!(
            "{:>7}  {kind:<11}{x:>10}{y:>10}{z:>10}{height:>8}{semi_diameter:>8.3}{incidence:>8}\
             {n:>8.4}{n_behind:>8.4}{passes:>8}",
            row + 1
        );
        self.lines += &(line + "\n");
    }

    /// Describes the path from one surface to the next.
    fn step(&mut self, job: &Job, i: usize, step: &PathStep) {
        let PathStep { emitted_radiance, emission, record, next, radiance, .. } = step;
        self.line("", "");
        self.hit(job, i, step);
        if *emitted_radiance != [0.0; 3] {
            self.line("", format!("emits {}", row(emitted_radiance)));
            self.line_at(PathStage::Emission(i), "", format!("adds {}", row(emission)));
        }
        if let Some(sample) = &record.light {
            self.light_sample(job, i, sample, step.shadow.as_ref());
        }
        self.line_at(PathStage::Sum(i), "", format!("radiance so far {}", row(radiance)));
        match next {
            Some((ray, throughput, density)) => {
                let (towards, density) = (row(&ray.direction), number(*density));
                self.line("", format!("continues towards {towards}, density {density}"));
                self.line_at(PathStage::Next(i), "", format!("throughput {}", row(throughput)));
            }
            None => self.line("", ending(record.outcome)),
        }
    }

    fn hit(&mut self, job: &Job, i: usize, step: &PathStep) {
        let PathStep { hit, surface, collision, record, .. } = step;
        let label = (i + 1).to_string();
        if let Some(Collision { medium, at }) = collision {
            let kind = job.scene.media[*medium as usize].kind();
            let distance = number(hit.t);
            self.line(&label, format!("scatters in medium {medium}, {kind}, distance {distance}"));
            return self.line("", format!("at {}", row(at)));
        }
        if *hit == Hit::ABSORBED {
            return self.line(&label, "is absorbed in a medium");
        }
        let Some([point, normal]) = surface else { return self.line(&label, "hits nothing") };
        let form = match &job.scene.shapes[hit.shape as usize].geometry {
            Geometry::Mesh(_) => format!("triangle {} of shape", hit.primitive),
            Geometry::Patches(_) => format!("patch {} of shape", hit.primitive),
            Geometry::Curves(_) => format!("curve segment {} of shape", hit.primitive),
            Geometry::Quadric(quadric) => format!("{}, shape", quadric.name()),
        };
        let material = match record.material {
            Some(material) => format!(", {}, material {material}", record.kind),
            None => String::new(),
        };
        let distance = number(hit.t);
        self.line(&label, format!("hits {form} {}{material}, distance {distance}", hit.shape));
        self.line("", format!("at {}", row(point)));
        self.line("", format!("normal {}", row(normal)));
        if let Some(shading) = record.normal.filter(|shading| shading != normal) {
            self.line("", format!("shading normal {}", row(&shading)));
        }
    }

    fn light_sample(
        &mut self,
        job: &Job,
        i: usize,
        sample: &SampledLight,
        shadow: Option<&ShadowRay>,
    ) {
        let SampledLight { light, pdf, radiance } = sample;
        let known = light.and_then(|i| Some((i, job.scene.lights.all.get(i as usize)?)));
        let light = known.map_or("a light".to_owned(), |(i, l)| format!("light {i} ({})", kind(l)));
        self.line("", format!("samples {light}, density {}", number(*pdf)));
        self.line_at(PathStage::Light(i), "", format!("radiance over density {}", row(radiance)));
        let Some(ShadowRay { ray, contribution, unoccluded }) = shadow else {
            return self.line("", "not scattered towards the viewer");
        };
        self.line("", format!("contribution {}", row(contribution)));
        self.line("", format!("along {}", row(&ray.direction)));
        self.line("", if *unoccluded { "visible" } else { "occluded" });
    }
}

/// Describes how a path ends.
fn ending(outcome: PathOutcome) -> String {
    match outcome {
        PathOutcome::Escapes => "the path leaves the scene".to_owned(),
        PathOutcome::DepthLimit => "the path ends: it has reached the maximum depth".to_owned(),
        PathOutcome::Absorbed | PathOutcome::Continues => {
            "the path ends: all light is absorbed".to_owned()
        }
        PathOutcome::Complete => "the path ends: the light sample above completes it".to_owned(),
        PathOutcome::Roulette { chance } => {
            format!(
                "the path ends by Russian roulette, with a probability of {} to continue",
                number(chance)
            )
        }
    }
}

fn kind(light: &Light) -> &'static str {
    match light {
        Light::Area(_) => "area",
        Light::Point(_) => "point",
        Light::Distant { .. } => "distant",
        Light::Infinite(_) => "infinite",
        Light::Portal(_) => "portal",
    }
}
