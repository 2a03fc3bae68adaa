//! Evaluation of a list of pictures, by the channels of their sensor.

use petzval_base::io::{ReadContext, path_excerpt};
use petzval_image::RawCodes;

use super::data_file::{PictureSet, dark_of};
use super::field_stack::{FieldStack, FieldStatistics, MIN_FIELD};
use super::photon_transfer::{Exposure, PhotonTransfer};

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

/// What all pictures have in common.
type Layout = ([usize; 2], Option<[u8; 4]>);

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

/// Reads the pictures of a list and evaluates each channel of their sensor. Exposures without dark pictures of the same
/// time are left out; [`parse_data_file`](super::parse_data_file) refuses them.
///
/// # Errors
/// Returns an error if a picture cannot be read or differs from the others in size or filters, or if the pictures tell
/// no parameters.
pub fn evaluate(
    sets: &[PictureSet],
    context: &ReadContext,
) -> Result<Vec<ChannelTransfer>, String> {
    let mut layout = None;
    let fields: Vec<Vec<FieldStatistics>> =
        sets.iter().map(|set| statistics(set, &mut layout, context)).collect::<Result<_, _>>()?;
    let Some((size, filters)) = layout else {
        return Err("it lists no pictures".to_owned());
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
        match PhotonTransfer::new(exposures.collect()) {
            Ok(transfer) => {
                Ok(ChannelTransfer { channel: channel.name, size: channel.size(size), transfer })
            }
            Err(error) if filters.is_some() => Err(format!("{}: {error}", channel.name)),
            Err(error) => Err(error.to_string()),
        }
    };
    Channel::of(filters).iter().enumerate().map(evaluated).collect()
}

/// Returns the statistics of each channel of a set of pictures.
fn statistics(
    set: &PictureSet,
    layout: &mut Option<Layout>,
    context: &ReadContext,
) -> Result<Vec<FieldStatistics>, String> {
    let mut stacks = Vec::new();
    let mut held = context.hold(0)?;
    for path in &set.pictures {
        let raw = RawCodes::read(path, &context.temporary()).map_err(|error| error.to_string())?;
        let file = path_excerpt(path);
        let channels = Channel::of(raw.filters);
        let found = (raw.size, raw.filters);
        let [width, height] = raw.size;
        match *layout {
            None => {
                let step = channels[0].step;
                if width.min(height) / step < MIN_FIELD {
                    return Err(format!(
                        "{file} has {width} x {height} pixels; expected at least {0} x {0}",
                        MIN_FIELD * step
                    ));
                }
                *layout = Some(found);
            }
            Some(expected) if expected != found => {
                let ([expected_width, expected_height], _) = expected;
                return Err(format!(
                    "{file} has {width} x {height} pixels{}; expected {expected_width} x {expected_height} with the \
                     same filters, as in the pictures before",
                    if raw.filters.is_some() { " behind filters" } else { "" }
                ));
            }
            Some(_) => {}
        }
        if stacks.is_empty() {
            // Two sums of each photosite.
            held.add(16 * (width * height) as u64)?;
            stacks = channels.iter().map(|c| FieldStack::new(c.size(raw.size))).collect();
        }
        for (stack, channel) in stacks.iter_mut().zip(&channels) {
            stack.add(channel.codes(&raw));
        }
    }
    Ok(stacks.iter().map(FieldStack::statistics).collect())
}
