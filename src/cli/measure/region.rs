//! Region of a picture that shows a chart.

use std::path::PathBuf;

use petzval_base::io::{ReadContext, path_excerpt};
use petzval_image::{Picture, Transfer};
use petzval_render::prepare::settings;
use serde_json::Value;

use super::super::Failure;
use super::super::arguments::values::typed;
use super::{divide, region_text, region_within, with_source};

/// Picture, region, and the picture of white that it is divided by.
#[derive(Debug, clap::Args)]
pub(super) struct RegionArguments {
    /// Picture: .exr, .hdr, .pfm, .png, .jpg, .tif
    pub picture: PathBuf,
    /// Region that star, patches or steps fill, without the frame of the chart, in pixels of the file; X1 and Y1 are not
    /// included
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = typed(settings::crop))]
    region: [[u32; 2]; 2],
    /// Picture of a white chart, by which the picture is divided: the light of the lens falls off to the corners
    #[arg(long, value_name = "PICTURE")]
    flat: Option<PathBuf>,
}

/// A picture that shows a chart in a region.
pub(super) struct ChartRegion {
    /// The picture, divided by that of white.
    pub picture: Picture,
    /// First column and row, and those that no longer belong to it.
    pub place: [[usize; 2]; 2],
    /// Mean luminance of white in the region, if it was divided out.
    pub white: Option<f64>,
}

impl RegionArguments {
    /// Reads the picture and divides it by that of white.
    ///
    /// # Errors
    /// Returns an error if a picture cannot be read, or if the region is not within it or not lit.
    pub fn read(&self, context: &ReadContext) -> Result<ChartRegion, Failure> {
        let mut picture = Picture::read_with(&self.picture, Transfer::Srgb, context)?;
        let place = region_within(&self.name(), self.region, &picture, &self.picture)?;
        let mut white = None;
        if let Some(flat) = &self.flat {
            white = Some(divide(&mut picture, flat, &[(self.name(), place)], context)?);
        }
        Ok(ChartRegion { picture, place, white })
    }

    /// Returns the option that asks for the region.
    pub fn name(&self) -> String {
        format!("--region {}", region_text(self.region))
    }

    /// Returns an error of the region with its place.
    pub fn fault(&self, error: &dyn std::fmt::Display) -> Failure {
        format!("{} of {}: {error}", self.name(), path_excerpt(&self.picture)).into()
    }

    /// Returns a result as JSON with the picture and the region.
    pub fn with_source(&self, found: Value) -> Value {
        with_source(found, &self.picture, Some(self.region))
    }
}
