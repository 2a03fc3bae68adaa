//! Corpus of lenses and rays that break tracers, each with its error bounds and their reason.

mod lenses;

pub use lenses::{asphere, wavy_asphere};
use lenses::{aspheres, conics, cylinders, gaps, radii, shaped, spheres};
use petzval_lens::{Prescription, Row};

use crate::support::lens;
use crate::support::probe::{
    Bench, RIM_TOLERANCE, Report, Start, compare, lens_of_rows, random_rays, rays_at_borders,
};

/// Promised error of f32 with rays retraced in f64, um and urad.
const PROMISE: [f64; 2] = [1.0, 5.0];

/// Promised error of f64, um and urad. Close to tangency and total internal reflection a rounding of
/// 1e-16 becomes its square root, 1e-8 rad, and a small multiple of that.
const PROMISE_F64: [f64; 2] = [1e-6, 0.1];

/// A lens, the region of its rays, and the error bounds.
pub struct Case {
    pub name: String,
    pub lens: Prescription,
    /// Distance of the film behind the rear vertex, mm.
    pub film: f64,
    /// Half the width of the film, and the radius of the disk that rays go to, mm.
    pub from: [f64; 2],
    /// Distance of the disk before the film, mm.
    pub ahead: f64,
    /// Bounds for f32 with retraced rays, um and urad.
    pub single: [f64; 2],
    /// Bounds for f64, um and urad.
    pub double: [f64; 2],
    /// Distance from a rim within which a ray may end on either side, in f32 and f64, mm.
    pub rims: [f64; 2],
    /// Reason for the bounds.
    pub reason: &'static str,
}

impl Case {
    fn bound(mut self, um: f64, urad: f64, reason: &'static str) -> Self {
        (self.single, self.reason) = ([um, urad], reason);
        self
    }

    fn exact_to(mut self, um: f64) -> Self {
        self.double[0] = um;
        self
    }

    pub fn rays(&self, bench: &Bench) -> Vec<Start> {
        let [height, reach] = self.from;
        let mut rays = random_rays(self.ahead, height, reach, 3000, 3);
        rays.extend(rays_at_borders(bench, self.ahead, self.from, 720, 7));
        rays
    }
}

fn case(name: impl Into<String>, rows: Vec<Row>, film: f64, from: [f64; 2]) -> Case {
    let (single, double, reason) = (PROMISE, PROMISE_F64, "the promise");
    Case {
        name: name.into(),
        lens: lens_of_rows(rows),
        film,
        from,
        ahead: film,
        single,
        double,
        rims: RIM_TOLERANCE,
        reason,
    }
}

pub fn corpus() -> Vec<Case> {
    let mut all = Vec::new();
    for (name, film) in crate::support::LENSES {
        let lens = lens(name);
        let rear = lens.rear().diameter * 0.6;
        let reason = "the fisheye's front magnifies angles";
        let urad = if name.starts_with("fisheye") { 6.0 } else { PROMISE[1] };
        let single = [PROMISE[0], urad];
        all.push(Case {
            name: name.into(),
            lens,
            film,
            ahead: film,
            from: [15.0, rear],
            single,
            double: PROMISE_F64,
            rims: RIM_TOLERANCE,
            reason,
        });
    }
    for add in [radii, spheres, gaps, conics, aspheres, cylinders, shaped] {
        add(&mut all);
    }
    all
}

#[test]
fn every_lens_of_the_corpus_stays_within_its_bounds() {
    let cases = corpus();
    let run = |case: &Case| {
        let bench = Bench::new(&case.lens, case.film);
        let rays = case.rays(&bench);
        (compare(&case.name, &bench, &rays, case.rims), rays)
    };
    let mut broken = Vec::new();
    println!(
        "case | f32 um, urad | retraced um, urad | f64 um, urad | passed | retraced / 1e6 | at rims f32, f64 | end in one only | end elsewhere"
    );
    let reports = crate::support::in_parallel(&cases, run);
    for (case, (report, rays)) in cases.iter().zip(reports) {
        let Report { single, retraced, double, .. } = &report;
        println!(
            "{} | {:.4} {:.3} | {:.4} {:.3} | {:.1e} {:.1e} | {:.3} | {:.0} | {} {} | {} {} | {}",
            case.name,
            single.um,
            single.urad,
            retraced.um,
            retraced.urad,
            double.um,
            double.urad,
            retraced.both as f64 / report.rays as f64,
            report.needs_f64 as f64 / report.rays as f64 * 1e6,
            retraced.at_rims,
            double.at_rims,
            retraced.disagreed,
            double.disagreed,
            report.other_ends,
        );
        for (name, off, [um, urad]) in
            [("f32", retraced, case.single), ("f64", double, case.double)]
        {
            if off.um > um || off.urad > urad || off.weight > 1e-6 {
                broken.push(format!(
                    "{} ({}), {name}: {off:?}, worst {:?}",
                    case.name,
                    case.reason,
                    off.worst.map(|i| rays[i])
                ));
            }
            if off.disagreed > 0 {
                broken.push(format!(
                    "{}, {name}: {} rays end in one only, {:?}",
                    case.name,
                    off.disagreed,
                    off.first_disagreed
                        .map(|i| (rays[i], Bench::new(&case.lens, case.film).outcome(rays[i])))
                ));
            }
        }
        if report.length[0] > 1e-5 || report.length[1] > 1e-12 {
            broken.push(format!("{}: |T| is off by {:?}", case.name, report.length));
        }
        if retraced.both < 30 {
            broken.push(format!("{}: too few rays come through to say anything", case.name));
        }
        if let Some((i, ours, outcome)) = report.first_other_end {
            broken.push(format!(
                "{}: {} rays end elsewhere, {:?} {ours:?} {outcome:?}",
                case.name, report.other_ends, rays[i]
            ));
        }
    }
    assert!(broken.is_empty(), "{} broken:\n{}", broken.len(), broken.join("\n"));
}
