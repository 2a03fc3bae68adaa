//! Coefficients of a medium that vary from point to point. Points are in the unit cube that its box
//! is mapped to.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::bricks::BrickGrid;
use super::cloud::CloudPattern;
use super::emission::Blackbodies;
use super::grid::{VoxelGrid, Voxels};
use crate::light::uplifted;

/// Coefficients of a medium at a point, by channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficients {
    /// Absorption coefficient.
    pub absorption: [f32; 3],
    /// Scattering coefficient.
    pub scattering: [f32; 3],
    /// Emitted radiance, which counts in proportion to the absorption.
    pub emission: [f32; 3],
}

/// A grid, and its place in the unit cube.
#[derive(Clone, Debug)]
pub struct PlacedGrid<G> {
    /// The grid.
    pub grid: G,
    /// The unit cube to the coordinates of voxels.
    pub voxel_from_unit: Affine3A,
}

impl<G: Voxels> PlacedGrid<G> {
    /// A grid whose voxels divide the unit cube; their values are those at their centres.
    pub fn filling(grid: G) -> Self {
        let size = Vec3::from(grid.resolution().map(|n| n as f32));
        let voxel_from_unit =
            Affine3A::from_scale_rotation_translation(size, Default::default(), Vec3::splat(-0.5));
        Self { grid, voxel_from_unit }
    }

    #[inline]
    fn at(&self, unit: Vec3) -> G::Value {
        self.grid.interpolate(self.voxel_from_unit.transform_point3(unit))
    }

    /// Returns the largest number of the voxels that determine the values in a box.
    fn maximum(&self, [low, high]: [Vec3; 2], number: impl Fn(G::Value) -> f32) -> f32 {
        let (mut first, mut last) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for corner in 0..8 {
            let of = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            let voxel = self.voxel_from_unit.transform_point3(Vec3::new(of(0), of(1), of(2)));
            (first, last) = (first.min(voxel), last.max(voxel));
        }
        let ends = self.grid.resolution();
        let range = |axis: usize| {
            // Rounding of a point on a face of the box may choose the next voxel.
            let start = (first[axis] - 0.01).floor().max(0.0) as u32;
            let end = ((last[axis] + 1.01).floor() + 1.0).max(0.0) as u32;
            start..end.min(ends[axis])
        };
        let mut maximum = 0.0f32;
        self.grid.visit_range([range(0), range(1), range(2)], &mut |value| {
            maximum = maximum.max(number(value));
        });
        maximum
    }
}

/// Densities in a grid of either form.
#[derive(Clone, Debug)]
pub enum ScalarGrid {
    /// All voxels.
    Dense(PlacedGrid<VoxelGrid<f32>>),
    /// Bricks where there are any.
    Sparse(Arc<PlacedGrid<BrickGrid>>),
}

impl ScalarGrid {
    #[inline]
    fn at(&self, unit: Vec3) -> f32 {
        match self {
            Self::Dense(grid) => grid.at(unit),
            Self::Sparse(grid) => grid.at(unit),
        }
    }

    fn maximum(&self, bounds: [Vec3; 2]) -> f32 {
        match self {
            Self::Dense(grid) => grid.maximum(bounds, |v| v),
            Self::Sparse(grid) => grid.maximum(bounds, |v| v),
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Self::Dense(grid) => grid.grid.bytes(),
            Self::Sparse(grid) => grid.grid.bytes(),
        }
    }

    fn resolution(&self) -> [u32; 3] {
        match self {
            Self::Dense(grid) => grid.grid.resolution(),
            Self::Sparse(grid) => grid.grid.resolution(),
        }
    }
}

/// Coefficients in proportion to a density.
#[derive(Clone, Debug)]
pub struct DensityField {
    /// Density, 0 or more.
    pub density: ScalarGrid,
    /// Absorption coefficient at density 1.
    pub absorption: [f32; 3],
    /// Scattering coefficient at density 1.
    pub scattering: [f32; 3],
    /// Emission.
    pub emission: Option<FieldEmission>,
}

/// Emission of a medium.
#[derive(Clone, Debug)]
pub enum FieldEmission {
    /// A radiance times a number at every point.
    Scaled {
        /// Radiance.
        radiance: [f32; 3],
        /// Factor.
        scale: ScalarGrid,
    },
    /// Black bodies, of the temperature at every point.
    Thermal {
        /// Temperature before offset and scale.
        temperature: ScalarGrid,
        /// Number that is subtracted from it.
        offset: f32,
        /// Factor of the difference (K).
        scale: f32,
        /// Factor of the radiance.
        strength: Option<ScalarGrid>,
        /// Radiances by temperature.
        radiance: Blackbodies,
    },
}

/// Coefficients of a medium as a function of the point.
#[derive(Clone, Debug)]
pub enum Field {
    /// In proportion to a density.
    Density(DensityField),
    /// Colours at every point; a grid that is not given is 1.
    Colour {
        /// Absorption coefficient.
        absorption: Option<PlacedGrid<VoxelGrid<Vec3>>>,
        /// Scattering coefficient.
        scattering: Option<PlacedGrid<VoxelGrid<Vec3>>>,
        /// Emitted radiance.
        emission: Option<PlacedGrid<VoxelGrid<Vec3>>>,
        /// Factor of absorption and scattering.
        scale: f32,
        /// Matrix of the colours, if paths carry other channels than RGB.
        uplift: Option<[[f32; 3]; 3]>,
    },
    /// A pattern of noise.
    Cloud {
        /// Density, 0 to 1.
        pattern: CloudPattern,
        /// Absorption coefficient at density 1.
        absorption: [f32; 3],
        /// Scattering coefficient at density 1.
        scattering: [f32; 3],
    },
}

/// Temperature below which black bodies count as dark (K), as in pbrt-v4.
const DARK: f32 = 100.0;

impl FieldEmission {
    fn at(&self, unit: Vec3) -> [f32; 3] {
        match self {
            Self::Scaled { radiance, scale } => {
                let scale = scale.at(unit).max(0.0);
                radiance.map(|channel| channel * scale)
            }
            Self::Thermal { temperature, offset, scale, strength, radiance } => {
                let strength = strength.as_ref().map_or(1.0, |grid| grid.at(unit));
                let kelvin = (temperature.at(unit) - offset) * scale;
                match strength > 0.0 && kelvin > DARK {
                    true => radiance.at(kelvin).map(|channel| channel * strength),
                    false => [0.0; 3],
                }
            }
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Self::Scaled { scale, .. } => scale.bytes(),
            Self::Thermal { temperature, strength, .. } => {
                temperature.bytes() + strength.as_ref().map_or(0, ScalarGrid::bytes)
            }
        }
    }
}

impl Field {
    /// Returns the name of its kind in reports.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Density(DensityField { density: ScalarGrid::Dense(_), .. }) => "uniformgrid",
            Self::Density(DensityField { density: ScalarGrid::Sparse(_), .. }) => "nanovdb",
            Self::Colour { .. } => "rgbgrid",
            Self::Cloud { .. } => "cloud",
        }
    }

    /// Returns the coefficients at a point.
    #[inline]
    pub(super) fn at(&self, unit: Vec3) -> Coefficients {
        match self {
            Self::Density(DensityField { density, absorption, scattering, emission }) => {
                let density = density.at(unit).max(0.0);
                Coefficients {
                    absorption: absorption.map(|a| a * density),
                    scattering: scattering.map(|s| s * density),
                    emission: emission.as_ref().map_or([0.0; 3], |emission| emission.at(unit)),
                }
            }
            Self::Colour { absorption, scattering, emission, scale, uplift } => {
                let of = |grid: &Option<PlacedGrid<VoxelGrid<Vec3>>>| {
                    let colour = grid.as_ref().map_or(Vec3::ONE, |grid| grid.at(unit));
                    uplifted((*scale * colour).to_array(), uplift)
                };
                let emission = emission.as_ref().map_or(Vec3::ZERO, |grid| grid.at(unit));
                Coefficients {
                    absorption: of(absorption),
                    scattering: of(scattering),
                    emission: uplifted(emission.to_array(), uplift),
                }
            }
            Self::Cloud { pattern, absorption, scattering } => {
                let density = pattern.density(unit);
                Coefficients {
                    absorption: absorption.map(|a| a * density),
                    scattering: scattering.map(|s| s * density),
                    emission: [0.0; 3],
                }
            }
        }
    }

    /// Returns an upper bound of the extinction coefficient of all channels in a box.
    pub(super) fn maximum(&self, bounds: [Vec3; 2]) -> f32 {
        let largest = |absorption: &[f32; 3], scattering: &[f32; 3]| {
            (0..3).map(|c| absorption[c] + scattering[c]).fold(0.0, f32::max)
        };
        match self {
            Self::Density(DensityField { density, absorption, scattering, .. }) => {
                density.maximum(bounds) * largest(absorption, scattering)
            }
            Self::Colour { absorption, scattering, scale, .. } => {
                let of = |grid: &Option<PlacedGrid<VoxelGrid<Vec3>>>| {
                    grid.as_ref().map_or(1.0, |grid| grid.maximum(bounds, Vec3::max_element))
                };
                scale * (of(absorption) + of(scattering))
            }
            Self::Cloud { absorption, scattering, .. } => largest(absorption, scattering),
        }
    }

    /// Returns the numbers of voxels along the axes; 1 if there are none.
    pub(super) fn resolution(&self) -> [u32; 3] {
        match self {
            Self::Density(field) => field.density.resolution(),
            Self::Colour { absorption, scattering, .. } => {
                let grid = absorption.as_ref().or(scattering.as_ref());
                grid.map_or([1; 3], |grid| grid.grid.resolution())
            }
            Self::Cloud { .. } => [1; 3],
        }
    }

    /// Returns the memory of its table of black bodies (bytes).
    pub(super) fn table_bytes(&self) -> usize {
        match self {
            Self::Density(DensityField {
                emission: Some(FieldEmission::Thermal { radiance, .. }),
                ..
            }) => radiance.bytes(),
            _ => 0,
        }
    }

    /// Returns its memory (bytes).
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Density(DensityField { density, emission, .. }) => {
                density.bytes() + emission.as_ref().map_or(0, FieldEmission::bytes)
            }
            Self::Colour { absorption, scattering, emission, .. } => {
                let grids = [absorption, scattering, emission];
                grids.into_iter().flatten().map(|grid| grid.grid.bytes()).sum()
            }
            Self::Cloud { .. } => 0,
        }
    }
}
