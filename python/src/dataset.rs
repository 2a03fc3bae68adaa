//! Data sets of paired pictures.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use petzval::{Progress, ReadContext, RenderError, RenderOptions};
use petzval_base::io::Outputs;
use petzval_tools::dataset::{
    DatasetError, DatasetScene, DatasetSpec, Manifest, prepare_pair, write_pair,
};
use pyo3::prelude::*;

use crate::error::{dataset_error, value_error};
use crate::job::check_threads;
use crate::worker;

/// A part of the pairs of a specification.
struct Part<'a> {
    spec: &'a Path,
    output: &'a Path,
    shard: [u32; 2],
    threads: usize,
}

/// Renders the pairs of a specification that are not there yet. Returns the path of the manifest.
///
/// `shard` is (i, n): the i-th of n parts, from 1.
#[pyfunction]
#[pyo3(signature = (spec, output, shard = [1, 1], threads = 0, progress = None))]
pub fn dataset(
    py: Python<'_>,
    spec: PathBuf,
    output: PathBuf,
    shard: [u32; 2],
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<PathBuf> {
    check_threads(threads)?;
    let [index, count] = shard;
    if !(1..=count).contains(&index) {
        return Err(value_error(format!("shard=({index}, {count}): expected (i, n), 1 <= i <= n")));
    }
    let (state, counts) = (Progress::default(), [AtomicU32::new(0), AtomicU32::new(0)]);
    let call = |py: Python<'_>| match &progress {
        Some(call) => {
            let [done, all] = counts.each_ref().map(|count| count.load(Ordering::Relaxed));
            call.call1(py, (f64::from(done) / f64::from(all.max(1)),)).map(|_| ())
        }
        None => Ok(()),
    };
    let part = Part { spec: &spec, output: &output, shard, threads };
    let work = || part.render(&state, &counts);
    let written =
        worker::run(py, &state.stop, call, work)?.map_err(|error| dataset_error(&error))?;
    call(py)?;
    Ok(written)
}

impl Part<'_> {
    fn render(
        &self,
        state: &Progress,
        [done, all]: &[AtomicU32; 2],
    ) -> Result<PathBuf, DatasetError> {
        let context = ReadContext::default();
        let spec = DatasetSpec::read(self.spec, &context)?;
        let [index, count] = self.shard;
        let pairs: Vec<u32> = (0..spec.pairs).filter(|pair| pair % count == index - 1).collect();
        all.store(pairs.len() as u32, Ordering::Relaxed);
        let outputs = Outputs::beside(&context.files());
        outputs.protect(&spec.named_files());
        std::fs::create_dir_all(self.output).map_err(|source| DatasetError::Io {
            verb: "write",
            path: self.output.to_owned(),
            source,
        })?;
        let mut manifest = Manifest::open(self.output, &spec.digest, self.shard, &outputs)?;
        let mut scenes: HashMap<PathBuf, DatasetScene> = HashMap::new();
        // The first pair must not replace a texture of the last one's scene.
        for &pair in pairs.iter().filter(|&&pair| !manifest.has(pair)) {
            if let Entry::Vacant(place) = scenes.entry(spec.draw(pair).scene) {
                let scene = DatasetScene::read(place.key(), &spec, &context)?;
                outputs.protect(&scene.files);
                place.insert(scene);
            }
        }
        for pair in pairs {
            if !manifest.has(pair) {
                let draw = spec.draw(pair);
                let pair = prepare_pair(&spec, draw.clone(), &scenes[&draw.scene])?;
                let options = RenderOptions {
                    threads: self.threads,
                    progress: Some(state),
                    ..RenderOptions::default()
                };
                let row = write_pair(&spec, &pair, manifest.folder(), &outputs, options)?;
                manifest.add(pair.draw.pair, row)?;
                if state.stop.load(Ordering::Relaxed) {
                    return Err(DatasetError::Render(RenderError::Stopped));
                }
            }
            done.fetch_add(1, Ordering::Relaxed);
        }
        manifest.create()?;
        Ok(manifest.path)
    }
}
