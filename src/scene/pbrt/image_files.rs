//! Image files that a scene names, each read once: those of textures in parallel at the end of the
//! scene file, those of lights and normal maps at once.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::params::Params;
use super::texture_library::TextureLibrary;
use super::{SceneError, resolve};
use crate::io::image::{Picture, Raster, Transfer};
use crate::io::{Location, ReadContext};
use crate::scene::{MipMap, PendingImage};

/// The image files that have been named so far.
#[derive(Default)]
pub(super) struct ImageFiles {
    requested: HashMap<(PathBuf, TransferKey), PendingImage>,
    /// Images that are still to be read, in the order in which they were named.
    unread: Vec<Request>,
    /// Images in f32.
    whole: HashMap<(PathBuf, TransferKey), Arc<Picture>>,
}

struct Request {
    path: PathBuf,
    transfer: Transfer,
    at: Location,
    image: PendingImage,
}

/// A transfer function as a hash key; a gamma by its bits.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum TransferKey {
    Linear,
    Srgb,
    Gamma(u32),
}

impl From<Transfer> for TransferKey {
    fn from(transfer: Transfer) -> Self {
        match transfer {
            Transfer::Linear => Self::Linear,
            Transfer::Srgb => Self::Srgb,
            Transfer::Gamma(gamma) => Self::Gamma(gamma.to_bits()),
        }
    }
}

impl ImageFiles {
    /// Returns the image that a parameter names, if it is given. [`Self::read`] fills it in.
    pub(super) fn request(
        &mut self,
        params: &Params,
        name: &str,
        transfer: Transfer,
    ) -> Result<Option<PendingImage>, SceneError> {
        let Some(file) = params.text(name)? else { return Ok(None) };
        let path = resolve(&params.folder, file);
        let at = params.location(name);
        let image = self.requested.entry((path.clone(), transfer.into())).or_insert_with(|| {
            let image = PendingImage::default();
            self.unread.push(Request { path, transfer, at, image: image.clone() });
            image
        });
        Ok(Some(image.clone()))
    }

    /// Reads all images that are requested and not read yet. Returns the error of each image that
    /// cannot be read, in the order of the scene file.
    pub(super) fn read(&mut self, context: &ReadContext) -> Vec<SceneError> {
        let read =
            |Request { path, transfer, at, image }| match Raster::read(&path, transfer, context) {
                Ok(raster) => {
                    image.set(MipMap::new(raster));
                    None
                }
                Err(source) => Some(SceneError::Image { at, source }),
            };
        std::mem::take(&mut self.unread).into_par_iter().filter_map(read).collect()
    }
}

impl TextureLibrary {
    /// Reads the image of a light or a normal map, in f32. As in pbrt, an empty name is no image.
    pub(super) fn whole_image(
        &mut self,
        params: &Params,
        name: &str,
        transfer: Transfer,
    ) -> Result<Option<Arc<Picture>>, SceneError> {
        let Some(file) = params.text(name)?.filter(|file| !file.is_empty()) else {
            return Ok(None);
        };
        let key = (resolve(&params.folder, file), transfer.into());
        if let Some(picture) = self.image_files.whole.get(&key) {
            return Ok(Some(picture.clone()));
        }
        let picture = Picture::read_with(&key.0, transfer, &params.context)
            .map_err(|source| SceneError::Image { at: params.location(name), source })?;
        if picture.pixels.is_empty() {
            return Err(params.refuse(name, "an image without pixels", "expected one or more"));
        }
        let picture = Arc::new(picture);
        self.image_files.whole.insert(key, picture.clone());
        Ok(Some(picture))
    }
}
