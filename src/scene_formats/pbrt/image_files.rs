//! Image files that a scene names, each read once: those of textures in parallel at the end of the
//! scene file, those of lights and normal maps at once.

use std::collections::HashMap;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::params::Params;
use super::texture_library::TextureLibrary;
use super::{SceneError, resolve};
use petzval_base::io::{Location, ReadContext};
use petzval_image::{ImageError, ImageSamples, Picture, Raster, Transfer};
use petzval_scene::{MipMap, PendingImage};

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
    ///
    /// Several at once need more memory for a time than one after another: an image that finds too
    /// little is read again alone.
    pub(super) fn read(&mut self, context: &ReadContext) -> Vec<SceneError> {
        let requests = std::mem::take(&mut self.unread);
        let results: Vec<_> = requests.par_iter().map(|request| request.read(context)).collect();
        let again = |(request, result): (&Request, Result<(), ImageError>)| {
            let crowded = |error: &ImageError| {
                matches!(error, ImageError::Io { source, .. }
                    if source.kind() == io::ErrorKind::OutOfMemory)
            };
            let source = match result {
                Err(error) if crowded(&error) => request.read(context).err()?,
                other => other.err()?,
            };
            Some(SceneError::Image { at: request.at.clone(), source })
        };
        requests.iter().zip(results).filter_map(again).collect()
    }
}

impl Request {
    /// Reads the image with all its scales.
    fn read(&self, context: &ReadContext) -> Result<(), ImageError> {
        let refused = |found| ImageError::Io {
            verb: "read",
            path: self.path.clone(),
            source: io::Error::new(io::ErrorKind::OutOfMemory, found),
        };
        let (raster, mut held) = Raster::read_held(&self.path, self.transfer, context)?;
        let floats = matches!(raster.samples, ImageSamples::Floats(_));
        let [kept, working] = MipMap::more_bytes(raster.size, raster.channels, floats);
        let bytes = raster.bytes() + kept;
        held.resize(bytes + working).map_err(refused)?;
        self.image.set(MipMap::new(raster));
        held.keep(bytes).map_err(refused)
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
