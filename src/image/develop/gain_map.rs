//! Gain maps of DNG files: factors on the readings of a sensor that correct the falloff of its lens (opcode `GainMap`,
//! Adobe, Digital Negative Specification 1.7.1.0, 2023, chapter 7).

use rayon::prelude::*;

use super::lens_opcodes::LensOpcode;

/// Names of opcodes, from identifier 1 on.
const NAMES: [&str; 14] = [
    "WarpRectilinear",
    "WarpFisheye",
    "FixVignetteRadial",
    "FixBadPixelsConstant",
    "FixBadPixelsList",
    "TrimBounds",
    "MapTable",
    "MapPolynomial",
    "GainMap",
    "DeltaPerRow",
    "DeltaPerColumn",
    "ScalePerRow",
    "ScalePerColumn",
    "WarpRectilinear2",
];
/// Bytes of the parameters of a gain map before its gains.
const HEAD: usize = 76;
/// Largest gain that is accepted, and largest reading after a map.
const MAX_GAIN: f32 = 1e4;
/// Most opcodes of a list: each gain map is a pass over the picture.
const MAX_OPCODES: u32 = 64;
/// Most corrections of the lens: each warp is a pass of 16 samples for each pixel and channel.
const MAX_LENS: usize = 8;

/// Factors on readings, linear between the points of a grid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GainMap {
    /// First row, first column, and the row and the column that are no longer multiplied.
    area: [u32; 4],
    /// Steps from row to row and from column to column.
    pitch: [u32; 2],
    /// Rows and columns of points.
    points: [usize; 2],
    /// Distances of points relative to the height and the width of the picture, and the place of the first.
    spacing: [f64; 2],
    origin: [f64; 2],
    /// Gains of the first plane, row after row.
    gains: Vec<f32>,
}

/// Opcodes of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Opcodes {
    /// Gain maps, in the order of their application.
    pub gain_maps: Vec<GainMap>,
    /// Corrections of pictures with all channels, in the order of their application.
    pub lens: Vec<LensOpcode>,
    /// Identifiers of those that are left out.
    pub left_out: Vec<u32>,
}

impl Opcodes {
    /// Identifier of the opcode of gain maps.
    pub const GAIN_MAP: u32 = 9;

    /// Returns the names of those that are left out, each once.
    pub fn names_left_out(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for id in &self.left_out {
            let name = match NAMES.get((*id as usize).wrapping_sub(1)) {
                Some(name) => (*name).to_owned(),
                None => format!("opcode {id}"),
            };
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// Reads a list of opcodes, whose numbers are big-endian in any file.
    ///
    /// # Errors
    /// Returns what was found if the list or a gain map is malformed.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let cut_off = || "is cut off".to_owned();
        let long = |at: usize| {
            let bytes = bytes.get(at..)?.first_chunk::<4>()?;
            Some(u32::from_be_bytes(*bytes))
        };
        let mut opcodes = Self::default();
        let mut at = 4;
        let count = long(0).ok_or_else(cut_off)?;
        if count > MAX_OPCODES {
            return Err(format!("has {count} opcodes; expected {MAX_OPCODES} or fewer"));
        }
        for _ in 0..count {
            let (id, length) = long(at).zip(long(at + 12)).ok_or_else(cut_off)?;
            let parameters = bytes[at + 16..].get(..length as usize).ok_or_else(cut_off)?;
            match id {
                Self::GAIN_MAP => match GainMap::parse(parameters)? {
                    Some(map) => opcodes.gain_maps.push(map),
                    None => opcodes.left_out.push(id),
                },
                _ => match LensOpcode::parse(id, parameters) {
                    Some(opcode) if opcodes.lens.len() < MAX_LENS => opcodes.lens.push(opcode),
                    _ => opcodes.left_out.push(id),
                },
            }
            at += 16 + length as usize;
        }
        Ok(opcodes)
    }
}

impl GainMap {
    /// Reads the parameters of a map; none of a map for other planes than the one of the readings.
    fn parse(bytes: &[u8]) -> Result<Option<Self>, String> {
        let malformed = |found: &str| format!("has a gain map {found}");
        let (head, gains) =
            bytes.split_at_checked(HEAD).ok_or_else(|| malformed("that is cut off"))?;
        let chunks = head.as_chunks::<4>().0;
        let long = |i: usize| u32::from_be_bytes(chunks[i]);
        let double = |i: usize| f64::from_bits(u64::from(long(i)) << 32 | u64::from(long(i + 1)));
        let points = [long(8), long(9)].map(|n| n as usize);
        let planes = long(18) as usize;
        let count = points[0].checked_mul(points[1]).and_then(|n| n.checked_mul(planes));
        let gains = gains.as_chunks::<4>().0;
        if count.is_none_or(|count| count == 0 || count > gains.len()) {
            let [rows, columns] = points;
            let found = gains.len();
            return Err(malformed(&format!(
                "of {rows} x {columns} points in {planes} planes with {found} gains; expected a gain for each"
            )));
        }
        let gains: Vec<f32> = gains
            .iter()
            .step_by(planes)
            .take(points[0] * points[1])
            .map(|gain| f32::from_be_bytes(*gain))
            .collect();
        let map = Self {
            area: [long(0), long(1), long(2), long(3)],
            pitch: [long(6), long(7)],
            points,
            spacing: [double(10), double(12)],
            origin: [double(14), double(16)],
            gains,
        };
        let is_sound = |gain: &f32| (0.0..=MAX_GAIN).contains(gain);
        let spaced =
            |i: usize| map.points[i] == 1 || (map.spacing[i] > 0.0 && map.spacing[i].is_finite());
        match map.gains.iter().all(is_sound)
            && (0..2).all(|i| map.pitch[i] > 0 && spaced(i) && map.origin[i].is_finite())
        {
            true => Ok((long(4) == 0 && long(5) > 0).then_some(map)),
            false => Err(malformed(
                "that is out of range; expected gains from 0 to 10000, pitches of 1 or more and points that are apart",
            )),
        }
    }

    /// Multiplies the readings of a sensor of this width and height (pixels).
    pub fn apply(&self, [width, height]: [usize; 2], readings: &mut [f32]) {
        let [top, left, bottom, right] = self.area.map(|border| border as usize);
        let [row_pitch, column_pitch] = self.pitch.map(|pitch| pitch as usize);
        let columns: Vec<(usize, [usize; 2], f32)> = (left..right.min(width))
            .step_by(column_pitch)
            .map(|x| {
                let (points, share) = self.between(1, x, width);
                (x, points, share)
            })
            .collect();
        readings.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
            if y < top || y >= bottom || (y - top) % row_pitch != 0 {
                return;
            }
            let ([above, below], down) = self.between(0, y, height);
            let mix = |a: f32, b: f32, share: f32| a + share * (b - a);
            for &(x, [before, after], across) in &columns {
                let in_row = |i: usize| {
                    let gains = &self.gains[i * self.points[1]..];
                    mix(gains[before], gains[after], across)
                };
                let gain = mix(in_row(above), in_row(below), down);
                row[x] = (row[x] * gain).clamp(-MAX_GAIN, MAX_GAIN);
            }
        });
    }

    /// Returns the points on both sides of a row or a column, and its share of the way from the first to the second.
    fn between(&self, axis: usize, at: usize, size: usize) -> ([usize; 2], f32) {
        let last = self.points[axis] - 1;
        if last == 0 {
            return ([0, 0], 0.0);
        }
        let place = (at as f64 + 0.5) / size as f64;
        let place = (place - self.origin[axis]) / self.spacing[axis];
        let place = place.clamp(0.0, last as f64);
        let before = (place as usize).min(last - 1);
        ([before, before + 1], (place - before as f64) as f32)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Returns a list of an unknown opcode and a gain map with the corners 1, 2, 3 and 4 for every second row from 0 and
    /// column from 1.
    pub(crate) fn list() -> Vec<u8> {
        let longs =
            |numbers: &[u32]| numbers.iter().flat_map(|n| n.to_be_bytes()).collect::<Vec<_>>();
        let doubles = [1.0, 1.0, 0.0, 0.0_f64].map(f64::to_be_bytes).concat();
        let gains = [1.0, 2.0, 3.0, 4.0_f32].map(f32::to_be_bytes).concat();
        [
            longs(&[2, 1, 0x0103_0000, 1, 4, 7]),
            longs(&[9, 0x0103_0000, 0, 92]),
            longs(&[0, 1, 100, 100, 0, 1, 2, 2, 2, 2]),
            doubles,
            longs(&[1]),
            gains,
        ]
        .concat()
    }

    #[test]
    fn gains_are_linear_between_points_and_for_their_photosites() {
        let opcodes = Opcodes::parse(&list()).unwrap();
        assert_eq!((opcodes.gain_maps.len(), &opcodes.left_out[..]), (1, &[1][..]));
        let mut readings = vec![1.0; 8 * 4];
        opcodes.gain_maps[0].apply([8, 4], &mut readings);
        for (i, gain) in readings.iter().enumerate() {
            let [x, y] = [i % 8, i / 8];
            let place = [(x as f32 + 0.5) / 8.0, (y as f32 + 0.5) / 4.0];
            let expected =
                if x % 2 == 1 && y % 2 == 0 { 1.0 + place[0] + 2.0 * place[1] } else { 1.0 };
            assert!((gain - expected).abs() < 1e-6, "{x},{y}: {gain}, not {expected}");
        }
    }

    #[test]
    fn maps_of_other_planes_are_left_out_and_other_gains_skipped() {
        let mut second_plane = list();
        // Plane is the fifth number of the map, which begins at byte 40.
        second_plane[40 + 19] = 1;
        let opcodes = Opcodes::parse(&second_plane).unwrap();
        assert_eq!((opcodes.gain_maps.len(), opcodes.left_out), (0, vec![1, 9]));
        // Of two planes of gains and one point, the first gain counts everywhere.
        let mut planes = list();
        let points = 40 + 32;
        planes[points..points + 8].copy_from_slice(&[0, 0, 0, 1, 0, 0, 0, 1]);
        planes[40 + 75] = 2;
        let opcodes = Opcodes::parse(&planes).unwrap();
        assert_eq!(opcodes.gain_maps[0].gains, [1.0]);
        let mut readings = vec![0.5; 8 * 4];
        opcodes.gain_maps[0].apply([8, 4], &mut readings);
        assert_eq!(readings, vec![0.5; 8 * 4]);
    }

    #[test]
    fn broken_lists_are_refused() {
        let whole = list();
        for length in 0..whole.len() {
            assert!(Opcodes::parse(&whole[..length]).is_err(), "{length}");
        }
        for i in 0..whole.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut broken = whole.clone();
                broken[i] = value;
                // No panic, neither by the reader nor by the map.
                if let Ok(opcodes) = Opcodes::parse(&broken) {
                    let mut readings = vec![1.0; 8 * 4];
                    opcodes.gain_maps.iter().for_each(|map| map.apply([8, 4], &mut readings));
                }
            }
        }
    }
}
