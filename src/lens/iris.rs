//! The shape of the opening of a stop.

/// What the opening of a stop looks like, inside its clear diameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Iris {
    /// A circle: the clear diameter itself.
    #[default]
    Round,
    /// The opening that blades leave; its corners touch the clear diameter.
    Blades {
        /// How many, from 3.
        count: u32,
        /// Angle of the first corner from +x towards +y, degrees.
        rotation: f64,
        /// Curvature of the blades' edges in units of the round opening's: 0 straight, 1 a circle.
        curvature: f64,
    },
    /// Transmission over the square around the clear diameter.
    Mask(Mask),
}

/// A square grid of transmissions from 0 to 1 over the square around an opening.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    /// What it is: a name of pbrt's or of a file.
    pub name: String,
    /// Rows and columns.
    pub size: usize,
    /// Row by row, the first at the top (+y), seen from the film.
    pub transmission: std::sync::Arc<[f32]>,
}
