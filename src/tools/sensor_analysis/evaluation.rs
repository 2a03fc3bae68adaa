//! Evaluation of a list of pictures, by the channels of their sensor.

use std::path::Path;

use petzval_base::io::{ReadContext, ReadError, path_excerpt, without_byte_order_mark};
use petzval_image::RawCodes;

use super::data_file::{ListedPicture, PictureSet, dark_of, parse_data_file};
use super::field_stack::{FieldStack, FieldStatistics, MIN_FIELD};
use super::photon_transfer::{Exposure, PhotonTransfer, TransferError};

/// Parameters of the photosites behind one of the filters.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelTransfer {
    /// Name of the channel: `grey` without filters, else `red`, `green/red` for green in the rows of red,
    /// `green/blue` and `blue`.
    pub channel: &'static str,
    /// Width and height (photosites).
    pub size: [usize; 2],
    /// Parameters.
    pub transfer: PhotonTransfer,
}

/// Size, filters and bits, which are the same in all pictures.
type Layout = ([usize; 2], Option<[u8; 4]>, u32);

/// Why a list of pictures cannot be evaluated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ListError {
    /// The list cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The list or one of its pictures is faulty: the place in the list, what was found and what was expected.
    #[error("{0}")]
    Malformed(String),
}

/// Why pictures of a list cannot be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{problem}", line.map_or_else(String::new, |line| format!("{line}:1: ")))]
struct EvaluationError {
    /// Number of the line of the list, from 1, if it is about one.
    line: Option<usize>,
    /// The fault, and what was expected.
    problem: String,
}

impl EvaluationError {
    fn at(line: usize, problem: impl ToString) -> Self {
        Self { line: Some(line), problem: problem.to_string() }
    }
}

/// A channel: its name, its first photosite and the step to the next one in both directions.
struct Channel {
    name: &'static str,
    first: [usize; 2],
    step: usize,
}

impl Channel {
    /// Returns the channels of a sensor.
    fn of(filters: Option<[u8; 4]>) -> Vec<Self> {
        let Some(filters) = filters else {
            return vec![Self { name: "grey", first: [0, 0], step: 1 }];
        };
        let mut channels: Vec<(u8, Self)> = Vec::new();
        for (i, filter) in filters.into_iter().enumerate() {
            let beside = filters[i ^ 1];
            let (order, name) = match (filter, beside) {
                (0, _) => (0, "red"),
                (1, 0) => (1, "green/red"),
                (1, _) => (2, "green/blue"),
                _ => (3, "blue"),
            };
            channels.push((order, Self { name, first: [i % 2, i / 2], step: 2 }));
        }
        channels.sort_by_key(|(order, _)| *order);
        channels.into_iter().map(|(_, channel)| channel).collect()
    }

    fn size(&self, size: [usize; 2]) -> [usize; 2] {
        [0, 1].map(|i| (size[i] - self.first[i].min(size[i])).div_ceil(self.step))
    }

    /// Returns the codes of the channel, row after row.
    fn codes<'a>(&self, raw: &'a RawCodes) -> impl Iterator<Item = f64> + 'a {
        let Self { first: [x, y], step, .. } = *self;
        let rows = raw.codes.chunks_exact(raw.size[0]).skip(y).step_by(step);
        rows.flat_map(move |row| row.iter().skip(x).step_by(step).map(|&code| f64::from(code)))
    }
}

/// Reads a list in the format of EMVA data sets and its pictures, and evaluates each channel of their sensor.
///
/// # Errors
/// Returns an error, with the place in the list, if a file cannot be read, if a picture differs from the others in size or
/// filters, or if the pictures tell no parameters.
pub fn evaluate_file(
    list: &Path,
    context: &ReadContext,
) -> Result<Vec<ChannelTransfer>, ListError> {
    let file = path_excerpt(list);
    let bytes = context.bytes(list)?;
    let malformed = |problem: String| ListError::Malformed(format!("{file}:{problem}"));
    let text = std::str::from_utf8(without_byte_order_mark(&bytes)).map_err(|error| {
        malformed(format!(" byte {} is not UTF-8; expected a list as text", error.valid_up_to()))
    })?;
    let sets = parse_data_file(text, list.parent().unwrap_or(list));
    let sets = sets.map_err(|problem| malformed(problem.to_string()))?;
    evaluate(&sets, context).map_err(|error| match error.line {
        Some(_) => malformed(error.to_string()),
        None => malformed(format!(" {error}")),
    })
}

/// Reads the pictures of a list and evaluates each channel of their sensor. Exposures without dark pictures of the same
/// time are left out; [`parse_data_file`] refuses them.
///
/// # Errors
/// Returns an error if a picture cannot be read or differs from the others in size or filters, or if the pictures tell
/// no parameters.
fn evaluate(
    sets: &[PictureSet],
    context: &ReadContext,
) -> Result<Vec<ChannelTransfer>, EvaluationError> {
    let mut layout = None;
    let fields: Vec<Vec<FieldStatistics>> =
        sets.iter().map(|set| statistics(set, &mut layout, context)).collect::<Result<_, _>>()?;
    let Some((size, filters, _)) = layout else {
        return Err(EvaluationError { line: None, problem: "it lists no pictures".to_owned() });
    };
    let lit = (0..sets.len()).filter(|&i| sets[i].light.is_some());
    let pairs: Vec<(usize, usize)> =
        lit.filter_map(|i| Some((i, dark_of(sets, sets[i].exposure)?))).collect();
    let evaluated = |(c, channel): (usize, &Channel)| {
        let exposures = pairs.iter().map(|&(light, dark)| Exposure {
            photons: sets[light].light.and_then(|light| light.photons),
            light: fields[light][c],
            dark: fields[dark][c],
        });
        let transfer =
            PhotonTransfer::new(exposures.collect()).map_err(|error| EvaluationError {
                line: match error {
                    TransferError::Dark { index, .. } => Some(sets[pairs[index].0].line),
                    _ => None,
                },
                problem: match filters {
                    Some(_) => format!("{}: {error}", channel.name),
                    None => error.to_string(),
                },
            })?;
        Ok(ChannelTransfer { channel: channel.name, size: channel.size(size), transfer })
    };
    Channel::of(filters).iter().enumerate().map(evaluated).collect()
}

/// Returns the statistics of each channel of a set of pictures.
fn statistics(
    set: &PictureSet,
    layout: &mut Option<Layout>,
    context: &ReadContext,
) -> Result<Vec<FieldStatistics>, EvaluationError> {
    if set.pictures.len() < 2 {
        return Err(EvaluationError::at(set.line, "the set has fewer than 2 pictures"));
    }
    let mut stacks = Vec::new();
    let exceeds = |found: String| EvaluationError::at(set.line, found);
    let mut held = context.hold(0).map_err(exceeds)?;
    for ListedPicture { line, path } in &set.pictures {
        let refused = |problem: String| EvaluationError::at(*line, problem);
        // Codes are dropped after use; the file stays an input.
        context
            .register(path)
            .map_err(|error| refused(format!("cannot read {}: {error}", path_excerpt(path))))?;
        let raw = RawCodes::read(path, &context.temporary())
            .map_err(|error| refused(error.to_string()))?;
        let channels = Channel::of(raw.filters);
        let found = (raw.size, raw.filters, raw.bits);
        let [width, height] = raw.size;
        if let Some(expected) = *layout
            && expected != found
        {
            return Err(refused(format!(
                "{} has {}; expected {}, as in the pictures before",
                path_excerpt(path),
                words_of(found),
                words_of(expected)
            )));
        }
        if layout.is_none() {
            let least = MIN_FIELD * channels[0].step;
            if width.min(height) < least {
                return Err(refused(format!(
                    "{} has {width} x {height} pixels; expected at least {least} x {least}",
                    path_excerpt(path)
                )));
            }
            *layout = Some(found);
        }
        if stacks.is_empty() {
            // Two sums of each photosite.
            held.add(16 * (width * height) as u64).map_err(exceeds)?;
            stacks = channels.iter().map(|c| FieldStack::new(c.size(raw.size))).collect();
        }
        for (stack, channel) in stacks.iter_mut().zip(&channels) {
            stack.add(channel.codes(&raw));
        }
    }
    Ok(stacks.iter().map(FieldStack::statistics).collect())
}

/// Describes size, filters and bits.
fn words_of(([width, height], filters, bits): Layout) -> String {
    let filters = match filters {
        None => "without filters".to_owned(),
        Some(filters) => {
            let letters: String =
                filters.map(|filter| ['R', 'G', 'B'][usize::from(filter)]).iter().collect();
            format!("behind the filters {letters}")
        }
    };
    format!("{width} x {height} pixels of {bits} bits {filters}")
}
