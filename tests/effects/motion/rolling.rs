//! Rolling shutter.

use petzval_render::plan::Effect;
use petzval_render::prepare::Changes;

use super::world::{SIZE, curtain, edge, job, row, taken, text};

/// Returns the column of the edge of a curtain that moves from x = -1 to x = 1 in a second.
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
fn a_moving_edge_is_skewed_by_speed_times_row_time() {
    for (reading, effects) in
        [("down", "-motion"), ("up", "-motion"), ("down", "auto"), ("up", "auto")]
    {
        let edges = edges(&format!("250ms,{reading}"), "open=.25,close=.5", effects, "");
        for (y, found) in edges.into_iter().enumerate() {
            let turn = y as f64 / (SIZE[1] - 1) as f64;
            let turn = if reading == "up" { 1.0 - turn } else { turn };
            let expected = at(0.375 + 0.25 * turn);
            // The blur covers eight pixels at 64 samples each.
            let noise = if effects == "auto" { 0.4 } else { 0.05 };
            assert!((found - expected).abs() < noise, "{reading} {y}: {found} for {expected}");
        }
    }
}

#[test]
fn reading_columns_along_or_against_the_motion_shifts_an_edge() {
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
fn motion_at_the_end_of_the_shutter_continues_for_later_rows() {
    // The last row is exposed after the end of the motion, which continues.
    let going = edges("300ms", "open=.8,close=1", "-motion", "");
    assert!((going[15] - at(1.2)).abs() < 0.05 && (going[0] - at(0.9)).abs() < 0.05, "{going:?}");
    // The motion ends at 0.9 s, during the exposure of the first row.
    let changes = Changes {
        rolling: Some("300ms".parse().expect("a time")),
        shutter: Some("open=.8,close=1".parse().expect("a shutter")),
        effects: "-motion".parse().expect("effects"),
        ..Changes::default()
    };
    let stopped = job(&text("TransformTimes -.1 .9", "", 64, &curtain(-1.0, 1.0)), &changes);
    // The rolling shutter then has no visible effect.
    assert!(!stopped.plan.has(Effect::RollingShutter), "{}", stopped.plan.line());
    let rows =
        edges("300ms", "open=.8,close=1", "-motion,+rolling_shutter", "TransformTimes -.1 .9");
    assert!(rows.iter().all(|edge| (edge - 48.0).abs() < 0.05), "{rows:?}");
}
