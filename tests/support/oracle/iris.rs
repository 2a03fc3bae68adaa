//! Openings of irises.

use petzval_lens::Iris;

/// Returns the distance of a point from the edge of an iris, mm, negative outside, and the transmission
/// at the point.
pub(super) fn margin_and_transmission(iris: &Iris, half: f64, [x, y]: [f64; 2]) -> (f64, f64) {
    match iris {
        Iris::Round => (f64::INFINITY, 1.0),
        Iris::Blades { count, rotation, curvature } => {
            let corner = |i: u32| {
                let angle = rotation.to_radians()
                    + std::f64::consts::TAU * f64::from(i) / f64::from(*count);
                [half * angle.cos(), half * angle.sin()]
            };
            let inside = (0..*count).map(|i| {
                let ([ax, ay], [bx, by]) = (corner(i), corner(i + 1));
                let chord = (bx - ax).hypot(by - ay);
                // The inside lies to the left of the chord.
                let left = [-(by - ay) / chord, (bx - ax) / chord];
                if *curvature == 0.0 {
                    return left[0] * (x - ax) + left[1] * (y - ay);
                }
                let radius = half / curvature;
                let back = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
                let centre = [(ax + bx) / 2.0 + back * left[0], (ay + by) / 2.0 + back * left[1]];
                radius - (x - centre[0]).hypot(y - centre[1])
            });
            let inside = inside.fold(f64::INFINITY, f64::min);
            (inside, f64::from(u8::from(inside >= 0.0)))
        }
        Iris::Mask(mask) => {
            let cell = 2.0 * half / mask.size as f64;
            let [column, row] = [(x + half) / cell, (half - y) / cell];
            let edge = |v: f64| (v - v.round()).abs() * cell;
            let rim = edge(column).min(edge(row));
            let within = 0.0..mask.size as f64;
            if !within.contains(&column) || !within.contains(&row) {
                return (-rim, 0.0);
            }
            let t = mask.transmission[row as usize * mask.size + column as usize];
            (rim, f64::from(t))
        }
    }
}
