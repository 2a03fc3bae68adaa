//! Pictures that textures name, each read once, all in parallel.

use std::collections::HashMap;
use std::path::PathBuf;

use rayon::prelude::*;

use super::SceneError;
use super::params::Params;
use crate::image::{Raster, Transfer};
use crate::scene::{Awaited, Pyramid};
use crate::source::Location;

/// The pictures that textures have named so far.
#[derive(Default)]
pub(super) struct Pictures {
    known: HashMap<(PathBuf, [u8; 5]), Awaited>,
    /// Those that are still to be read, in the order in which they were named.
    missing: Vec<Order>,
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
        let path = params.folder.join(file);
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
            let raster =
                Raster::read(&path, transfer).map_err(|source| SceneError::Image { at, source })?;
            picture.arrive(Pyramid::new(raster));
            Ok(())
        };
        let done: Vec<Result<(), SceneError>> =
            std::mem::take(&mut self.missing).into_par_iter().map(read).collect();
        done.into_iter().collect()
    }
}
