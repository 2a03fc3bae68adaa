//! Optimization against formulas and spoiled designs.

use petzval_lens::{Prescription, Row};
use petzval_optics::{
    DesignGoal, DesignTarget, DesignVariable, ImagingConditions, OptimizedDesign, Refocus,
    optimize_design,
};

use super::{conditions, lens, singlet};

fn goal(lens: &Prescription, variables: &[&str], targets: &[&str], shares: &[f64]) -> DesignGoal {
    DesignGoal {
        variables: variables
            .iter()
            .map(|name| DesignVariable::named(name, lens).expect("a variable"))
            .collect(),
        targets: targets
            .iter()
            .map(|target| target.parse::<DesignTarget>().expect("a target"))
            .collect(),
        refocus: Refocus::Fields,
        least_edge: 0.1,
        shares: shares.to_vec(),
        rings: 5,
        iterations: 200,
        threads: 1,
    }
}

fn optimized(
    lens: &Prescription,
    conditions: &ImagingConditions,
    goal: &DesignGoal,
) -> OptimizedDesign {
    let design = optimize_design(lens, conditions, goal, |_, _| true).expect("a merit");
    assert!(design.end.merit <= design.start.merit, "{design:?}");
    design
}

#[test]
fn a_singlet_bends_to_the_shape_of_least_spherical_aberration() {
    let start = singlet([0.01, -0.01], 10.0);
    let goal = goal(&start, &["c1", "c2"], &["efl=100", "spot"], &[0.0]);
    let found = optimized(&start, &conditions(&start, 1.0), &goal);
    let [c1, c2] = [found.end.variables[0], found.end.variables[1]];
    // Shape factor q = (c1 + c2) / (c1 - c2) of a thin lens for a distant object:
    // 2 (n^2 - 1) / (n + 2) (Jenkins & White, "Fundamentals of Optics", 9.5).
    let (q, best) = ((c1 + c2) / (c1 - c2), 2.0 * (1.5 * 1.5 - 1.0) / 3.5);
    assert!((q - best).abs() < 0.02, "q {q}, expected {best}");
    assert!((found.end.targets[0] - 100.0).abs() < 1e-3, "{:?}", found.end);
}

#[test]
fn a_spherical_mirror_becomes_a_paraboloid() {
    let mirror = Row { radius: -200.0, diameter: 40.0, mirror: true, stop: true, ..Row::default() };
    let start = Prescription::new("mirror", vec![mirror]).expect("one stop");
    let goal = goal(&start, &["k1"], &["spot"], &[0.0]);
    let found = optimized(&start, &conditions(&start, 1.0), &goal);
    assert!((found.end.variables[0] + 1.0).abs() < 1e-6, "{:?}", found.end);
    assert!(found.end.merit < 1e-8 && (found.end.film_distance - 100.0).abs() < 1e-6);
}

#[test]
fn a_spoiled_radius_of_a_triplet_returns() {
    let design = lens("triplet.toml");
    let conditions = conditions(&design, 15.0);
    // The design is at its own optimum first, so that there is a radius to return to.
    let variables = ["r3"];
    let goal = goal(&design, &variables, &["spot"], &[0.0, 0.7, 1.0]);
    let best = optimized(&design, &conditions, &goal);
    let mut spoiled = design.clone();
    spoiled.rows[2].radius *= 1.05;
    let found = optimized(&spoiled, &conditions, &goal);
    assert!(found.start.merit > 1.1 * best.end.merit, "{found:?}");
    let [expected, radius] = [&best, &found].map(|design| design.end.variables[0].recip());
    assert!((radius / expected - 1.0).abs() < 2e-3, "{radius} {expected}");
}

#[test]
fn bounds_hold_and_a_film_target_moves_the_film() {
    let start = singlet([0.01, -0.01], 10.0);
    let mut goal = goal(&start, &["t1", "film"], &["film=90"], &[0.0]);
    goal.refocus = Refocus::Off;
    goal.variables[0].bounds = [0.4, 0.6];
    let found = optimized(&start, &conditions(&start, 1.0), &goal);
    assert!((found.end.film_distance - 90.0).abs() < 1e-9, "{:?}", found.end);
    assert!((0.4..=0.6).contains(&found.end.variables[0]));
    // A thinner lens has a longer back focus; no thickness gives it 10 mm more.
    let mut goal = self::goal(&start, &["t1"], &["bfd=120"], &[0.0]);
    goal.variables[0].bounds = [0.4, 0.6];
    let found = optimized(&start, &conditions(&start, 1.0), &goal);
    assert_eq!(found.end.variables[0], 0.4, "{:?}", found.end);
}

#[test]
fn distortion_and_back_focus_reach_their_targets() {
    let start = lens("triplet.toml");
    let targets = ["efl=48", "bfd=41", "distortion=-1"];
    let goal = goal(&start, &["r1", "r2", "r5", "r6"], &targets, &[0.0, 0.7, 1.0]);
    let found = optimized(&start, &conditions(&start, 15.0), &goal);
    for (value, target) in found.end.targets.iter().zip([48.0, 41.0, -1.0]) {
        assert!((value - target).abs() < 1e-4, "{:?}", found.end);
    }
}
