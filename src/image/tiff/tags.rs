//! Numbers of tags of TIFF 6.0, TIFF/EP and DNG 1.7 that readers and writers need.

pub const NEW_SUBFILE_TYPE: u16 = 254;
pub const WIDTH: u16 = 256;
pub const HEIGHT: u16 = 257;
pub const BITS: u16 = 258;
pub const COMPRESSION: u16 = 259;
pub const PHOTOMETRIC: u16 = 262;
pub const STRIP_OFFSETS: u16 = 273;
pub const ORIENTATION: u16 = 274;
pub const SAMPLES: u16 = 277;
pub const ROWS_PER_STRIP: u16 = 278;
pub const STRIP_BYTES: u16 = 279;
pub const TILE_SIZE: [u16; 2] = [322, 323];
pub const TILE_OFFSETS: u16 = 324;
pub const TILE_BYTES: u16 = 325;
pub const SUB_DIRECTORIES: u16 = 330;
pub const CFA_SIZE: u16 = 33421;
pub const CFA_PATTERN: u16 = 33422;
pub const LINEARIZATION_TABLE: u16 = 50712;
pub const BLACK_LEVEL_SIZE: u16 = 50713;
pub const BLACK_LEVEL: u16 = 50714;
pub const BLACK_LEVEL_DELTAS: [u16; 2] = [50715, 50716];
pub const WHITE_LEVEL: u16 = 50717;
pub const DEFAULT_CROP_ORIGIN: u16 = 50719;
pub const DEFAULT_CROP_SIZE: u16 = 50720;
pub const COLOR_MATRIX: [u16; 2] = [50721, 50722];
pub const CAMERA_CALIBRATION: [u16; 2] = [50723, 50724];
pub const ANALOG_BALANCE: u16 = 50727;
pub const AS_SHOT_NEUTRAL: u16 = 50728;
pub const AS_SHOT_WHITE: u16 = 50729;
pub const BASELINE_EXPOSURE: u16 = 50730;
pub const CALIBRATION_ILLUMINANT: [u16; 2] = [50778, 50779];
pub const ACTIVE_AREA: u16 = 50829;
pub const CALIBRATION_SIGNATURES: [u16; 2] = [50931, 50932];
pub const FORWARD_MATRIX: [u16; 2] = [50964, 50965];
pub const OPCODE_LISTS: [u16; 3] = [51008, 51009, 51022];

/// Photometric interpretation of raw data behind colour filters.
pub const COLOR_FILTER_ARRAY: u16 = 32803;
/// `CalibrationIlluminant` of illuminant A and of D65: light sources of Exif.
pub const TUNGSTEN: u16 = 17;
pub const D65: u16 = 21;

/// Names of entries in messages.
const NAMES: [(u16, &str); 22] = [
    (COMPRESSION, "Compression"),
    (PHOTOMETRIC, "PhotometricInterpretation"),
    (STRIP_OFFSETS, "StripOffsets"),
    (STRIP_BYTES, "StripByteCounts"),
    (CFA_PATTERN, "CFAPattern"),
    (LINEARIZATION_TABLE, "LinearizationTable"),
    (BLACK_LEVEL_SIZE, "BlackLevelRepeatDim"),
    (BLACK_LEVEL, "BlackLevel"),
    (WHITE_LEVEL, "WhiteLevel"),
    (DEFAULT_CROP_ORIGIN, "DefaultCropOrigin"),
    (DEFAULT_CROP_SIZE, "DefaultCropSize"),
    (COLOR_MATRIX[0], "ColorMatrix1"),
    (COLOR_MATRIX[1], "ColorMatrix2"),
    (ANALOG_BALANCE, "AnalogBalance"),
    (AS_SHOT_NEUTRAL, "AsShotNeutral"),
    (AS_SHOT_WHITE, "AsShotWhiteXY"),
    (BASELINE_EXPOSURE, "BaselineExposure"),
    (ACTIVE_AREA, "ActiveArea"),
    (FORWARD_MATRIX[0], "ForwardMatrix1"),
    (FORWARD_MATRIX[1], "ForwardMatrix2"),
    (OPCODE_LISTS[1], "OpcodeList2"),
    (OPCODE_LISTS[2], "OpcodeList3"),
];

/// Returns the name of an entry for a message.
pub fn name(tag: u16) -> String {
    match NAMES.iter().find(|(other, _)| *other == tag) {
        Some((_, name)) => (*name).to_owned(),
        None => format!("entry {tag}"),
    }
}
