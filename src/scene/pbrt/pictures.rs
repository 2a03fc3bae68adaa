//! Pictures that scene files name, each read once; those of textures all in parallel.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use super::params::Params;
use super::textures::Library;
use super::{SceneError, resolve};
use crate::image::{Picture, Raster, Transfer};
use crate::scene::{Awaited, Pyramid};
use crate::source::{Files, Location, reading};

/// The pictures that have been named so far.
#[derive(Default)]
pub(super) struct Pictures {
    known: HashMap<(PathBuf, [u8; 5]), Awaited>,
    /// Those that are still to be read, in the order in which they were named.
    missing: Vec<Order>,
    /// Those that are wanted whole, by file and whether they were decoded from sRGB.
    whole: HashMap<(PathBuf, bool), Arc<Picture>>,
}

struct Order {
    path: PathBuf,
    transfer: Transfer,
    at: Location,
    picture: Awaited,
}

/// A transfer curve as something that can be looked up.
fn key(transfer: Transfer) -> [u8; 5] {
    let (kind, gamma) = match transfer {
        Transfer::Linear => (0, 0.0),
        Transfer::Srgb => (1, 0.0),
        Transfer::Gamma(gamma) => (2, gamma),
    };
    let [a, b, c, d] = gamma.to_bits().to_ne_bytes();
    [kind, a, b, c, d]
}

impl Pictures {
    /// The picture that a parameter names. It arrives with [`Self::read`].
    pub(super) fn order(
        &mut self,
        params: &Params,
        name: &str,
        transfer: Transfer,
    ) -> Result<Option<Awaited>, SceneError> {
        let Some(file) = params.text(name)? else { return Ok(None) };
        let path = resolve(&params.folder, file);
        let at = params.find(name).map_or(&params.at, |param| &param.at).clone();
        let picture = self.known.entry((path.clone(), key(transfer))).or_insert_with(|| {
            let picture = Awaited::default();
            let order = Order { path, transfer, at, picture: picture.clone() };
            self.missing.push(order);
            picture
        });
        Ok(Some(picture.clone()))
    }

    /// Reads what is missing.
    ///
    /// # Errors
    /// The first that cannot be read, in the order of the scene file.
    pub(super) fn read(&mut self) -> Result<(), SceneError> {
        let read = |Order { path, transfer, at, picture }| {
            let (raster, files) = reading(|| Raster::read(&path, transfer));
            let raster = raster.map_err(|source| SceneError::Image { at, source })?;
            picture.arrive(Pyramid::new(raster));
            Ok(files)
        };
        let done: Vec<Result<Files, SceneError>> =
            std::mem::take(&mut self.missing).into_par_iter().map(read).collect();
        done.into_iter().try_for_each(|files| {
            files?.noted();
            Ok(())
        })
    }
}

impl Library {
    /// A picture that a light or a map of normals names, whole and in floats.
    pub(super) fn picture(
        &mut self,
        params: &Params,
        name: &str,
        folder: &Path,
        srgb: bool,
    ) -> Result<Option<Arc<Picture>>, SceneError> {
        let Some(file) = params.text(name)? else { return Ok(None) };
        let key = (resolve(folder, file), srgb);
        if let Some(picture) = self.pictures.whole.get(&key) {
            return Ok(Some(picture.clone()));
        }
        let picture = Picture::read(&key.0, srgb).map_err(|source| {
            let at = params.find(name).map_or(&params.at, |param| &param.at);
            SceneError::Image { at: at.clone(), source }
        })?;
        if picture.pixels.is_empty() {
            return Err(params.refuse(name, "a picture without pixels", ""));
        }
        let picture = Arc::new(picture);
        self.pictures.whole.insert(key, picture.clone());
        Ok(Some(picture))
    }
}
