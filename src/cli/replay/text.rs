//! A replayed sample in words.

use std::fmt::Write as _;

use petzval::lens::{Blocked, Crossing, Model, Passage, Why};
use petzval::render::{Job, Place, Replay, Shadow, Step};
use petzval::scene::{Geometry, Light};
use petzval::shade::{Fate, Looked};

/// The way of a sample, no line wider than a terminal of 100.
pub(super) fn text(job: &Job, replay: &Replay) -> String {
    let ([x, y], breaks) = (replay.name.pixel(), replay.breaks());
    let mut text = Text { lines: String::new(), breaks };
    let (sample, seed) = (replay.name.sample, replay.name.seed);
    text.line("sample", format!("pixel {x},{y}, number {sample}, seed {seed}"));
    let unit = if matches!(job.camera.model, Model::Real(_)) { " mm" } else { "" };
    text.line("film", format!("{}{unit}; weight {}", row(&replay.film), number(replay.weight)));
    if let Some(time) = replay.time {
        text.line("time", format!("{} of the motion", number(time)));
    }
    text.light(job, replay);
    match (&replay.passage, &job.camera.model) {
        (Some(passage), _) => text.passage(passage),
        (None, Model::Real(_)) => text.line("lens", "no light comes to this point of the film"),
        (None, Model::Thin(_)) => {}
    }
    if let Some((ray, carried)) = &replay.ray {
        text.line("", "");
        text.line("ray", format!("from {}", row(&ray.origin)));
        text.line("", format!("towards {}", row(&ray.direction)));
        text.line_at(Place::Ray, "", format!("carries {}", row(carried)));
    }
    replay.steps.iter().enumerate().for_each(|(i, step)| text.step(job, i, step));
    text.line("", "");
    text.line("radiance", row(&replay.radiance));
    match replay.value {
        // So many digits that they can be read back.
        Some([r, g, b]) => text.line("adds", format!("{r:e} {g:e} {b:e}")),
        None => text.line("adds", "nothing: it is no number, and is dropped"),
    }
    if job.ghosts.is_some() {
        text.line("", "ghosts add to the pixel too: they are of no sample");
    }
    if let Some(place) = breaks {
        text.line("first", format!("{} is no finite number", super::words(place)));
    }
    text.lines
}

/// A number of six digits or so.
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
    /// What is marked.
    breaks: Option<Place>,
}

impl Text {
    fn line(&mut self, name: &str, what: impl std::fmt::Display) {
        let line = format!("{name:<10}{what}");
        let _ = writeln!(self.lines, "{}", line.trim_end());
    }

    /// A line that is marked where the way breaks there.
    fn line_at(&mut self, place: Place, name: &str, what: String) {
        let mark = if self.breaks == Some(place) { "   <- no number" } else { "" };
        self.line(name, what + mark);
    }

    /// The bands of the light.
    fn light(&mut self, job: &Job, replay: &Replay) {
        let (Some(band), Model::Real(lens)) = (replay.band, &job.camera.model) else { return };
        let (of, wavelength) = (lens.bands.len(), lens.bands[band].wavelength);
        self.line("light", format!("band {} of {of}, {wavelength:.1} nm", band + 1));
        for shared in replay.shared.iter().skip(1) {
            let lands = match shared.landing {
                Some((film, share)) => {
                    format!("lands at {} mm, {} of it", row(&film), number(share))
                }
                None => "does not come to the film".to_owned(),
            };
            self.line("", format!("{:.1} nm of its ray {lands}", shared.wavelength));
        }
    }

    /// The way through the lens.
    fn passage(&mut self, passage: &Passage) {
        let Passage { start, towards, weight, redone, crossings, end } = passage;
        let three = |v: &[f64; 3]| v.map(number).join("  ");
        self.line("", "");
        let frame = "mm; z from the front vertex to the film";
        self.line("lens", format!("from {} ({frame})", three(start)));
        self.line("", format!("towards {}; weight {}", three(towards), number(*weight)));
        if *redone {
            self.line("", "f32 cannot trace it exactly enough: f64 does");
        }
        let head = format!(
            "{:>7}  {:<11}{:>10}{:>10}{:>10}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}",
            "surface", "kind", "x", "y", "z", "height", "clear", "angle", "n", "n'", "passes"
        );
        self.lines += &(head + "\n");
        crossings.iter().for_each(|crossing| self.crossing(crossing));
        if let Err(Blocked { row, why }) = end {
            let why = match why {
                Why::Clip => "it comes outside the clear aperture",
                Why::Stop => "it comes outside the opening of the stop",
                Why::Miss => "it does not meet it",
                Why::Tir => "it is totally reflected",
            };
            self.line("", format!("the ray ends at surface {}: {why}", row + 1));
        }
    }

    fn crossing(&mut self, crossing: &Crossing) {
        let Crossing { row, kind, at, height, clear, incidence, index, passed } = crossing;
        let fixed = |value: Option<f64>, digits: usize| match value {
            Some(value) => format!("{value:.digits$}"),
            None => "-".to_owned(),
        };
        let [x, y, z] = [0, 1, 2].map(|i| fixed(at.map(|at| at[i]), 4));
        let [height, incidence] = [fixed(*height, 3), fixed(*incidence, 2)];
        let passed = passed.map_or("no".to_owned(), |passed| format!("{passed:.4}"));
        let [n, behind] = index;
        let line = format!(
            "{:>7}  {kind:<11}{x:>10}{y:>10}{z:>10}{height:>8}{clear:>8.3}{incidence:>8}{n:>8.4}\
             {behind:>8.4}{passed:>8}",
            row + 1
        );
        self.lines += &(line + "\n");
    }

    /// What happens from one surface to the next.
    fn step(&mut self, job: &Job, i: usize, step: &Step) {
        let Step { emits, shone, account, next, radiance, .. } = step;
        self.line("", "");
        self.meets(job, i, step);
        if *emits != [0.0; 3] {
            self.line("", format!("emits {}", row(emits)));
            self.line_at(Place::Emission(i), "", format!("which adds {}", row(shone)));
        }
        if let Some(looked) = &account.looked {
            self.looks(job, i, looked, step.shadow.as_ref());
        }
        self.line_at(Place::Sum(i), "", format!("radiance so far {}", row(radiance)));
        match next {
            Some((ray, carried, density)) => {
                let (towards, density) = (row(&ray.direction), number(*density));
                self.line("", format!("goes on towards {towards}, density {density}"));
                self.line_at(Place::Next(i), "", format!("carries {}", row(carried)));
            }
            None => self.line("", ends(account.fate)),
        }
    }

    fn meets(&mut self, job: &Job, i: usize, step: &Step) {
        let Step { hit, met, account, .. } = step;
        let place = (i + 1).to_string();
        let Some([at, normal]) = met else { return self.line(&place, "meets nothing") };
        let form = match &job.scene.shapes[hit.shape as usize].geometry {
            Geometry::Mesh(_) => format!("triangle {} of shape", hit.primitive),
            Geometry::Quadric(quadric) => format!("{}, shape", quadric.name()),
        };
        let material = match account.material {
            Some(material) => format!(", {}, material {material}", account.kind),
            None => String::new(),
        };
        let distance = number(hit.t);
        self.line(&place, format!("meets {form} {}{material}, distance {distance}", hit.shape));
        self.line("", format!("at {}", row(at)));
        self.line("", format!("normal {}", row(normal)));
        if let Some(shading) = account.normal.filter(|shading| shading != normal) {
            self.line("", format!("normal for shading {}", row(&shading)));
        }
    }

    fn looks(&mut self, job: &Job, i: usize, looked: &Looked, shadow: Option<&Shadow>) {
        let Looked { light, density, radiance } = looked;
        let known = light.and_then(|i| Some((i, job.scene.lights.all.get(i as usize)?)));
        let light = known.map_or("a light".to_owned(), |(i, l)| format!("light {i} ({})", kind(l)));
        let density = number(*density);
        self.line("", format!("looks at {light}, chosen with the density {density}"));
        self.line_at(Place::Light(i), "", format!("radiance over density {}", row(radiance)));
        let Some(Shadow { ray, brings, arrives }) = shadow else {
            return self.line("", "of which nothing is scattered this way");
        };
        self.line("", format!("which brings {}", row(brings)));
        self.line("", format!("along {}", row(&ray.direction)));
        self.line("", if *arrives { "it arrives" } else { "something is in its way" });
    }
}

/// How a path ends.
fn ends(fate: Fate) -> String {
    match fate {
        Fate::Escapes => "the path leaves the scene".to_owned(),
        Fate::Deepest => "the path ends: it has met as many surfaces as it may".to_owned(),
        Fate::Absorbed | Fate::GoesOn => "the path ends: nothing is left of it".to_owned(),
        Fate::Complete => "the path ends: its last light came from the light above".to_owned(),
        Fate::Roulette { chance } => {
            format!(
                "the path ends by Russian roulette, with a chance of {} to go on",
                number(chance)
            )
        }
    }
}

fn kind(light: &Light) -> &'static str {
    match light {
        Light::Area(_) => "area",
        Light::Lamp(_) => "lamp",
        Light::Distant { .. } => "distant",
        Light::Infinite(_) => "infinite",
    }
}
