//! Blur of an edge that moves while the shutter is open.

use petzval_render::plan::Effect;
use petzval_render::prepare::Changes;
use petzval_scene::shutter::ShutterSettings;

use super::world::{curtain, job, profile, taken, text};

/// Path of the edge, from x = -1 to x = 0.75: 28 pixels of 64.
const PATH: [f64; 2] = [-1.0, 0.75];

/// Returns the light of a column. `after` is the light that passes the shutter after a time.
fn expected(column: usize, after: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 400;
    let one = |step: u32| {
        let x = (column as f64 + (f64::from(step) + 0.5) / f64::from(STEPS) - 32.0) / 16.0;
        // The column sees the sky until the edge arrives.
        let covered = ((x - PATH[0]) / (PATH[1] - PATH[0])).clamp(0.0, 1.0);
        after(0.0) - after(covered)
    };
    (0..STEPS).map(one).sum::<f64>() / f64::from(STEPS)
}

fn compare(shutter: &str, camera: &str, after: impl Fn(f64) -> f64) {
    let settings = match shutter {
        "" => ShutterSettings::default(),
        _ => shutter.parse().expect(shutter),
    };
    let changes = Changes { shutter: Some(settings), ..Changes::default() };
    let job = job(&text("", camera, 1024, &curtain(PATH[0], PATH[1])), &changes);
    assert!(job.plan.has(Effect::Motion) && !job.plan.has(Effect::RollingShutter));
    for (column, found) in profile(&taken(&job)).into_iter().enumerate() {
        let expected = expected(column, &after);
        assert!(
            (found - expected).abs() < 4e-3 * after(0.0),
            "{shutter}: {found} for {expected} at {column}"
        );
    }
}

#[test]
fn a_moving_edge_is_a_ramp() {
    compare("", "", |time| 1.0 - time);
}

#[test]
fn a_slow_shutter_rounds_the_ramp_and_reduces_the_light() {
    // The shutter opens within 0.25 s and closes within 0.5 s of 1 s: 0.625 of the light.
    let through = |time: f64| {
        let (opening, closing) = (time.min(0.25), (time - 0.5).max(0.0));
        2.0 * opening * opening + (time - opening) - closing * closing
    };
    let after = |time: f64| 0.625 - through(time);
    compare("opening=0.25,closing=0.5", "", after);
    compare("", "\"float shutterramp\" [0.25 0.5]", after);
    assert!((through(1.0) - 0.625).abs() < 1e-12);
    // The same curve as a table.
    compare("curve=0/1/1/.5/0", "", after);
}

#[test]
fn a_shorter_exposure_has_a_shorter_ramp_and_less_light() {
    compare("open=0.25,close=0.75", "", |time| 0.75 - time.clamp(0.25, 0.75));
    // The edge rests before the start and after the end.
    compare("open=-1,close=2", "", |time| match time {
        0.0 => 3.0,
        time if time < 1.0 => 2.0 - time,
        _ => 0.0,
    });
}
