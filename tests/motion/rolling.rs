//! Rows that are read one after another.

use petzval::job::Changes;
use petzval::plan::Effect;

use super::world::{SIZE, curtain, edge, job, row, taken, text};

/// The curtain goes from x = -1 to x = 1 in a second.
fn at(seconds: f64) -> f64 {
    32.0 + 16.0 * (2.0 * seconds - 1.0)
}

fn edges(rolling: &str, shutter: &str, effects: &str, options: &str) -> Vec<f64> {
    let changes = Changes {
        rolling: Some(rolling.parse().expect(rolling)),
        shutter: Some(shutter.parse().expect(shutter)),
        effects: effects.parse().expect(effects),
        ..Changes::default()
    };
    let job = job(&text(options, "", 64, &curtain(-1.0, 1.0)), &changes);
    assert!(job.plan.has(Effect::RollingShutter), "{}", job.plan.line());
    assert_eq!(job.plan.has(Effect::Motion), effects == "auto");
    let picture = taken(&job);
    let seen = job.camera.imaging_ratio;
    let rows = (0..SIZE[1]).map(|y| row(&picture, y).iter().map(|v| v / seen).collect::<Vec<_>>());
    rows.map(|row| edge(&row)).collect()
}

#[test]
fn a_moving_edge_leans_by_its_speed_times_the_time_of_a_row() {
    for (reading, effects) in
        [("down", "-motion"), ("up", "-motion"), ("down", "auto"), ("up", "auto")]
    {
        let edges = edges(&format!("250ms,{reading}"), "open=.25,close=.5", effects, "");
        for (y, found) in edges.into_iter().enumerate() {
            let turn = y as f64 / (SIZE[1] - 1) as f64;
            let turn = if reading == "up" { 1.0 - turn } else { turn };
            let expected = at(0.375 + 0.25 * turn);
            // Blurred over eight pixels, by 64 samples each.
            let noise = if effects == "auto" { 0.4 } else { 0.05 };
            assert!((found - expected).abs() < noise, "{reading} {y}: {found} for {expected}");
        }
    }
}

#[test]
fn columns_that_are_read_along_or_against_the_motion_move_an_edge() {
    for reading in ["right", "left"] {
        let width = SIZE[0] as f64;
        let dark = |column: usize| {
            let turn = column as f64 / (width - 1.0);
            let turn = if reading == "left" { 1.0 - turn } else { turn };
            (at(0.25 + 0.5 * turn) - column as f64).clamp(0.0, 1.0)
        };
        let expected: f64 = (0..SIZE[0]).map(dark).sum();
        for found in edges(&format!("0.5,{reading}"), "open=0,close=.5", "-motion", "") {
            assert!((found - expected).abs() < 0.05, "{reading}: {found} for {expected}");
        }
    }
}

#[test]
fn what_moves_when_the_shutter_closes_goes_on_for_later_rows_and_what_stopped_does_not() {
    // The last row is read after the end of the motion, and sees it go on.
    let going = edges("300ms", "open=.8,close=1", "-motion", "");
    assert!((going[15] - at(1.2)).abs() < 0.05 && (going[0] - at(0.9)).abs() < 0.05, "{going:?}");
    // Its second ends at 0.9 s, while the first row is exposed.
    let changes = Changes {
        rolling: Some("300ms".parse().expect("a time")),
        shutter: Some("open=.8,close=1".parse().expect("a shutter")),
        effects: "-motion".parse().expect("effects"),
        ..Changes::default()
    };
    let stopped = job(&text("TransformTimes -.1 .9", "", 64, &curtain(-1.0, 1.0)), &changes);
    // So nothing is left to be seen of its rows.
    assert!(!stopped.plan.has(Effect::RollingShutter), "{}", stopped.plan.line());
    let rows =
        edges("300ms", "open=.8,close=1", "-motion,+rolling_shutter", "TransformTimes -.1 .9");
    assert!(rows.iter().all(|edge| (edge - 48.0).abs() < 0.05), "{rows:?}");
}
