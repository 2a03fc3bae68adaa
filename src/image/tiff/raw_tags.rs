//! Levels, gain maps, crop and orientation of a DNG.

use super::mosaic::RawDirectory;
use super::raw_colours::read_colours;
use super::tags;
use crate::develop::{LensOpcode, Opcodes, RawFile};

/// Largest correction of the exposure that is accepted (stops).
const MAX_EXPOSURE: f64 = 32.0;

/// Reads a raw file.
///
/// # Errors
/// Returns what was found if the file has no raw data that this reads, or if its levels or colours are missing or
/// of another form.
pub(crate) fn read_raw(bytes: &[u8]) -> Result<RawFile, String> {
    let raw = RawDirectory::find(bytes)?;
    let codes = raw.codes()?;
    let (file, first) = (&raw.file, raw.first);
    let of_data = |tag| file.reals(raw.directory, tag);
    let of_camera = |tag| file.reals(first, tag);
    for tag in tags::BLACK_LEVEL_DELTAS {
        if of_data(tag)?.is_some_and(|deltas| deltas.iter().any(|&delta| delta != 0.0)) {
            return Err("its black level differs from row to row or from column to column; expected one for each \
                        filter"
                .to_owned());
        }
    }
    let levels = of_data(tags::BLACK_LEVEL)?.unwrap_or_else(|| vec![0.0]);
    let size = of_data(tags::BLACK_LEVEL_SIZE)?.unwrap_or_else(|| vec![1.0, 1.0]);
    let black = match (&size[..], &levels[..]) {
        ([1.0, 1.0], &[level]) => [level; 4],
        ([1.0, 2.0], &[a, b]) => [a, b, a, b],
        ([2.0, 1.0], &[a, b]) => [a, a, b, b],
        ([2.0, 2.0], &[a, b, c, d]) => [a, b, c, d],
        _ => {
            return Err(format!(
                "its black level is given for {} photosites; expected one, or a pattern of up to two by two",
                levels.len()
            ));
        }
    };
    let white = of_data(tags::WHITE_LEVEL)?.and_then(|levels| levels.first().copied());
    let white = white.unwrap_or_else(|| f64::from(codes.bits).exp2() - 1.0);
    if !black.iter().all(|&black| black >= 0.0 && white - black >= 1.0) {
        return Err(format!(
            "its black levels are {black:?} and its white level is {white}; expected black levels from 0 to below the white \
             level"
        ));
    }
    let exposure = of_camera(tags::BASELINE_EXPOSURE)?.and_then(|found| found.first().copied());
    let exposure = exposure.unwrap_or(0.0);
    if exposure.abs() > MAX_EXPOSURE {
        return Err(format!(
            "its BaselineExposure is {exposure} stops; expected at most {MAX_EXPOSURE} in either direction"
        ));
    }
    let origin = of_data(tags::DEFAULT_CROP_ORIGIN)?.unwrap_or_else(|| vec![0.0; 2]);
    let crop = match of_data(tags::DEFAULT_CROP_SIZE)? {
        Some(size) => Some(crop(&origin, &size, codes.size)?),
        None => None,
    };
    let orientation = of_camera(tags::ORIENTATION)?.and_then(|found| found.first().copied());
    let colours = match codes.filters {
        Some(_) => {
            let [of_camera_file, of_profile] = tags::CALIBRATION_SIGNATURES;
            let of_camera_file = text_of(file.blob(first, of_camera_file)?);
            let is_calibrated = of_camera_file == text_of(file.blob(first, of_profile)?);
            Some(read_colours(&of_camera, is_calibrated)?)
        }
        None => None,
    };
    let mut opcodes = Opcodes::default();
    for tag in tags::OPCODE_LISTS {
        let Some(list) = file.blob(raw.directory, tag)? else { continue };
        let found =
            Opcodes::parse(list).map_err(|found| format!("its {} {found}", tags::name(tag)))?;
        // The second list applies to readings, the third to all channels.
        if tag == tags::OPCODE_LISTS[1] {
            opcodes.gain_maps = found.gain_maps;
        } else {
            opcodes.left_out.extend(found.gain_maps.iter().map(|_| Opcodes::GAIN_MAP));
        }
        if tag == tags::OPCODE_LISTS[2] {
            opcodes.lens = found.lens;
        } else {
            opcodes.left_out.extend(found.lens.iter().map(LensOpcode::id));
        }
        opcodes.left_out.extend(found.left_out);
    }
    let orientation = orientation.filter(|orientation| (1.0..9.0).contains(orientation));
    Ok(RawFile {
        codes,
        black,
        white,
        colours,
        opcodes,
        exposure,
        crop,
        orientation: orientation.unwrap_or(1.0) as u8,
    })
}

/// Returns a text without the zeros at its end; an empty one if there is none.
fn text_of(bytes: Option<&[u8]>) -> &[u8] {
    let bytes = bytes.unwrap_or_default();
    let length = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    &bytes[..length]
}

/// Returns the part of a picture that is to be shown: first column and row, and those that no longer are.
fn crop(origin: &[f64], size: &[f64], picture: [usize; 2]) -> Result<[[usize; 2]; 2], String> {
    let [&[x, y], &[width, height]] = [origin, size] else {
        return Err(
            "its DefaultCropOrigin or DefaultCropSize has other than two numbers".to_owned()
        );
    };
    let (origin, size) = ([x, y], [width, height]);
    let within = |i: usize| {
        let [from, length] = [origin[i], size[i]].map(f64::round);
        let fits = from >= 0.0 && length >= 1.0 && from + length <= picture[i] as f64;
        fits.then_some([from as usize, (from + length) as usize])
    };
    match (within(0), within(1)) {
        (Some([left, right]), Some([top, bottom])) => Ok([[left, top], [right, bottom]]),
        _ => Err(format!(
            "its DefaultCrop of {size:?} pixels from {origin:?} is not within its {} x {} pixels",
            picture[0], picture[1]
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::WhiteBalance;
    use crate::develop::gain_map_tests::list;

    /// An entry: its tag, its type, and its elements.
    type Entry = (u16, u16, Vec<u8>);

    fn shorts(tag: u16, numbers: &[u16]) -> Entry {
        (tag, 3, numbers.iter().flat_map(|number| number.to_le_bytes()).collect())
    }

    fn doubles(tag: u16, numbers: &[f64]) -> Entry {
        (tag, 12, numbers.iter().flat_map(|number| number.to_le_bytes()).collect())
    }

    /// Returns a file of 8 x 4 pixels of a code, with these entries besides those of its codes.
    fn file(code: u16, filtered: bool, more: &[Entry]) -> Vec<u8> {
        let codes = code.to_le_bytes().repeat(32);
        let mut entries = vec![
            shorts(tags::WIDTH, &[8]),
            shorts(tags::HEIGHT, &[4]),
            shorts(tags::BITS, &[16]),
            shorts(tags::PHOTOMETRIC, &[if filtered { tags::COLOR_FILTER_ARRAY } else { 34892 }]),
            shorts(tags::STRIP_OFFSETS, &[8]),
            shorts(tags::STRIP_BYTES, &[64]),
        ];
        if filtered {
            entries.push(shorts(tags::CFA_SIZE, &[2, 2]));
            entries.push((tags::CFA_PATTERN, 1, vec![0, 1, 1, 2]));
        }
        entries.extend_from_slice(more);
        let mut bytes = [b"II*\0", &72_u32.to_le_bytes()[..], &codes].concat();
        let mut data: Vec<u8> = Vec::new();
        let data_from = 72 + 2 + 12 * entries.len() + 4;
        bytes.extend((entries.len() as u16).to_le_bytes());
        for (tag, kind, elements) in &entries {
            let size = match kind {
                3 => 2,
                12 => 8,
                _ => 1,
            };
            bytes.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
            bytes.extend(((elements.len() / size) as u32).to_le_bytes());
            if elements.len() <= 4 {
                bytes.extend(elements.iter().chain(&[0; 4]).take(4));
            } else {
                bytes.extend(((data_from + data.len()) as u32).to_le_bytes());
                data.extend_from_slice(elements);
            }
        }
        bytes.extend([0; 4]);
        bytes.extend(data);
        bytes
    }

    fn colours() -> Vec<Entry> {
        let unity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        vec![
            doubles(tags::COLOR_MATRIX[0], &unity),
            doubles(tags::AS_SHOT_WHITE, &[0.3127, 0.3290]),
        ]
    }

    /// Returns the pixel in the middle of the developed file.
    fn shown(code: u16, filtered: bool, more: &[Entry]) -> Result<[f32; 3], String> {
        let raw = read_raw(&file(code, filtered, more))?;
        let developed = raw.develop(WhiteBalance::Off).map_err(|error| error.to_string())?;
        let [width, height] = developed.picture.size;
        Ok(developed.picture.pixels[height / 2 * width + width / 2])
    }

    fn is_near(found: [f32; 3], expected: [f32; 3]) -> bool {
        (0..3).all(|c| (found[c] - expected[c]).abs() < 1e-3)
    }

    #[test]
    fn levels_of_every_form_are_read() {
        let black = |size: &[u16], levels: &[u16]| {
            let more = [
                shorts(tags::BLACK_LEVEL_SIZE, size),
                shorts(tags::BLACK_LEVEL, levels),
                shorts(tags::WHITE_LEVEL, &[1100]),
            ];
            read_raw(&file(600, false, &more)).map(|raw| raw.black)
        };
        assert_eq!(black(&[1, 1], &[100]), Ok([100.0; 4]));
        assert_eq!(black(&[1, 2], &[100, 90]), Ok([100.0, 90.0, 100.0, 90.0]));
        assert_eq!(black(&[2, 1], &[100, 90]), Ok([100.0, 100.0, 90.0, 90.0]));
        assert_eq!(black(&[2, 2], &[1, 2, 3, 4]), Ok([1.0, 2.0, 3.0, 4.0]));
        assert!(black(&[2, 2], &[100]).unwrap_err().contains("1 photosites; expected one, or"));
        assert!(black(&[1, 1], &[1100]).unwrap_err().contains("to below the white level"));
        let deltas = read_raw(&file(600, false, &[shorts(tags::BLACK_LEVEL_DELTAS[1], &[0, 1])]));
        assert!(deltas.unwrap_err().contains("from row to row"));
        // Without levels, 65535 is white. A grey picture has no colours.
        let grey = shown(32768, false, &[]).unwrap();
        assert!(is_near(grey, [0.5; 3]), "{grey:?}");
        let stops = shown(16384, false, &[doubles(tags::BASELINE_EXPOSURE, &[-1.0])]).unwrap();
        assert!(is_near(stops, [0.125; 3]), "{stops:?}");
        let far = read_raw(&file(1, false, &[doubles(tags::BASELINE_EXPOSURE, &[2000.0])]));
        assert!(far.unwrap_err().contains("BaselineExposure is 2000 stops"));
    }

    #[test]
    fn white_balances_and_calibrations_count_as_the_specification_says() {
        // X, Y and Z of a light, as codes, are white in that light.
        let xyz = [0.9505, 1.0, 1.0888];
        let neutral = [colours(), vec![doubles(tags::AS_SHOT_NEUTRAL, &xyz)]].concat();
        for more in [&colours(), &neutral] {
            let raw = read_raw(&file(6000, true, more)).unwrap();
            let white = raw.develop(WhiteBalance::Off).unwrap().white.unwrap();
            assert!(
                (white[0] - 0.3127).abs() < 1e-4 && (white[1] - 0.3290).abs() < 1e-4,
                "{white:?}"
            );
        }
        let plain = shown(6000, true, &colours()).unwrap();
        // Twice the gain of red halves red.
        let gains = [colours(), vec![doubles(tags::ANALOG_BALANCE, &[2.0, 1.0, 1.0])]].concat();
        assert!(shown(6000, true, &gains).unwrap()[0] < 0.7 * plain[0]);
        let mut calibrated = colours();
        let twice = [2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        calibrated.push(doubles(tags::CAMERA_CALIBRATION[0], &twice));
        assert!(shown(6000, true, &calibrated).unwrap()[0] < 0.7 * plain[0]);
        // One that was made for another profile does not count.
        calibrated.push((tags::CALIBRATION_SIGNATURES[0], 2, b"maker\0".to_vec()));
        assert!(is_near(shown(6000, true, &calibrated).unwrap(), plain));
        calibrated.push((tags::CALIBRATION_SIGNATURES[1], 2, b"maker\0".to_vec()));
        assert!(shown(6000, true, &calibrated).unwrap()[0] < 0.7 * plain[0]);
        for (entry, expected) in [
            (doubles(tags::AS_SHOT_NEUTRAL, &[1.0, 1.0]), "has 2 numbers; expected 3"),
            (
                doubles(tags::FORWARD_MATRIX[0], &[1.0]),
                "its ForwardMatrix1 has 1 numbers; expected 9",
            ),
            (doubles(tags::COLOR_MATRIX[1], &[1e9; 9]), "singular or too large"),
            (doubles(tags::ANALOG_BALANCE, &[f64::NAN, 1.0, 1.0]), "expected finite numbers"),
            (doubles(tags::AS_SHOT_NEUTRAL, &[0.0, 1.0, 1.0]), "no white in this light"),
        ] {
            let refused = shown(6000, true, &[colours(), vec![entry]].concat()).unwrap_err();
            assert!(refused.contains(expected), "{refused}");
        }
    }

    #[test]
    fn gain_maps_and_crops_are_applied() {
        let opcodes = (tags::OPCODE_LISTS[1], 7, list());
        let crop =
            [shorts(tags::DEFAULT_CROP_ORIGIN, &[5, 0]), shorts(tags::DEFAULT_CROP_SIZE, &[3, 2])];
        let raw = read_raw(&file(16384, false, &[&crop[..], &[opcodes]].concat())).unwrap();
        let developed = raw.develop(WhiteBalance::Off).unwrap();
        assert_eq!(developed.picture.size, [3, 2]);
        assert_eq!(developed.left_out, ["WarpRectilinear"]);
        // Column 5 and row 0 of 8 x 4 pixels.
        let expected = 0.25 * (1.0 + 5.5 / 8.0 + 2.0 * 0.5 / 4.0);
        let found = developed.picture.pixels[0][1];
        assert!((found - expected).abs() < 1e-4, "{found}, not {expected}");
        assert!((developed.picture.pixels[1][1] - 0.25).abs() < 1e-4);
        // A crop without its origin begins at the first pixel.
        let from_first = read_raw(&file(1, false, &crop[1..])).unwrap();
        assert_eq!(from_first.crop, Some([[0, 0], [3, 2]]));
        // Gain maps of other lists are named.
        let other = read_raw(&file(1, false, &[(tags::OPCODE_LISTS[2], 7, list())])).unwrap();
        assert_eq!(other.opcodes.names_left_out(), ["GainMap", "WarpRectilinear"]);
        assert!(other.opcodes.gain_maps.is_empty());
        let wide = [crop[0].clone(), shorts(tags::DEFAULT_CROP_SIZE, &[4, 2])];
        let refused = read_raw(&file(1, false, &wide)).unwrap_err();
        assert!(refused.contains("is not within its 8 x 4 pixels"), "{refused}");
    }

    #[test]
    fn readings_below_black_stay_finite_under_many_gain_maps() {
        let [head, map] = [&list()[..4], &list()[24..]];
        let mut many = [&head[..3], &[64], &map.repeat(64)].concat();
        for gain in many[4..].chunks_mut(map.len()).flat_map(|map| map[92..].chunks_mut(4)) {
            gain.copy_from_slice(&1e4_f32.to_be_bytes());
        }
        for filtered in [false, true] {
            let more = [
                colours(),
                vec![(tags::OPCODE_LISTS[1], 7, many.clone()), shorts(tags::BLACK_LEVEL, &[64])],
            ];
            let raw = read_raw(&file(1, filtered, &more.concat())).unwrap();
            assert_eq!(raw.opcodes.gain_maps.len(), 64);
            let developed = raw.develop(WhiteBalance::Off).unwrap();
            let values = developed.picture.pixels.as_flattened();
            assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
        }
        many[3] = 65;
        let more = [(tags::OPCODE_LISTS[1], 7, many)];
        let refused = read_raw(&file(1, false, &more)).unwrap_err();
        assert!(
            refused.contains("its OpcodeList2 has 65 opcodes; expected 64 or fewer"),
            "{refused}"
        );
    }

    #[test]
    fn any_byte_may_be_wrong() {
        let all = [
            colours(),
            vec![
                (tags::OPCODE_LISTS[1], 7, list()),
                shorts(tags::DEFAULT_CROP_ORIGIN, &[1, 0]),
                shorts(tags::DEFAULT_CROP_SIZE, &[5, 4]),
                shorts(tags::ORIENTATION, &[6]),
                shorts(tags::BLACK_LEVEL, &[64]),
                doubles(tags::BASELINE_EXPOSURE, &[0.5]),
            ],
        ]
        .concat();
        let whole = file(600, true, &all);
        read_raw(&whole).unwrap().develop(WhiteBalance::Off).unwrap();
        for i in 0..whole.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut broken = whole.clone();
                broken[i] = value;
                // No panic, and no pixel that is not finite.
                let Ok(raw) = read_raw(&broken) else { continue };
                for white in [WhiteBalance::Off, WhiteBalance::Auto] {
                    let Ok(developed) = raw.develop(white) else { continue };
                    let values = developed.picture.pixels.as_flattened();
                    assert!(values.iter().all(|value| value.is_finite()), "byte {i}: {value}");
                }
            }
        }
    }
}
