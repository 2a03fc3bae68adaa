//! Cells of a hexapolar grid.

/// Cell of a hexapolar grid over the stop: ring k has 6 k cells, and all rings are equally wide.
pub(super) struct HexapolarCell {
    /// Ring, 0 for the middle.
    pub ring: u32,
    /// Place in the ring.
    pub place: u32,
    /// Number of rings around the middle.
    pub rings: u32,
    /// Radius of the grid, relative to the stop.
    pub reach: f64,
}

impl HexapolarCell {
    /// Returns a point of the cell by its shares along the radius and around the axis.
    pub fn point(&self, along: f64, around: f64) -> [f64; 2] {
        let width = self.reach / (f64::from(self.rings) + 0.5);
        let ring = f64::from(self.ring);
        let (radius, turn) = match self.ring {
            0 if (along, around) == (0.5, 0.5) => (0.0, 0.0),
            0 => (0.5 * along.max(0.0).sqrt(), around),
            _ => (ring - 0.5 + along, (f64::from(self.place) + around) / (6.0 * ring)),
        };
        let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
        [width * radius * cos, width * radius * sin]
    }

    /// Returns the middle of part `i` of `side` x `side`. The parts of neighbours have other radii,
    /// so that a round rim does not pass many at once as it grows. Parts above and below the x axis
    /// mirror each other.
    pub fn part(&self, i: usize, side: usize) -> [f64; 2] {
        let column = i / side;
        let number = self.place as usize * side + column;
        let mirrored = (6 * self.ring as usize).max(1) * side - 1 - number;
        // Multiples of the golden ratio are spread evenly.
        let stagger = 0.618_033_988_75 * number.min(mirrored) as f64;
        let along = ((i % side) as f64 + stagger.fract()) / side as f64;
        self.point(along, (column as f64 + 0.5) / side as f64)
    }

    /// Returns the area relative to that of a cell of a ring.
    pub fn area(&self) -> f64 {
        if self.ring == 0 { 0.75 } else { 1.0 }
    }
}
