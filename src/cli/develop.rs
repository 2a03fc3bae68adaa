//! `petzval develop`: a picture of a raw file.

use std::path::PathBuf;

use petzval_base::io::{Outputs, path_excerpt};
use petzval_image::{
    DisplayExposure, EncodingOptions, ImageFormat, Note, PictureWindow, RawFile, ToneCurve,
    WhiteBalance,
};

use super::arguments::argv::{argv, shell_line};
use super::arguments::encoding::FileArguments;
use super::arguments::values::raw_white_balance;
use super::memory::Memory;
use super::outputs::claim_writable;
use super::{Failure, Outcome};

/// Arguments of `petzval develop`.
#[derive(Debug, clap::Args)]
pub(super) struct DevelopArguments {
    /// Raw file: a .dng, uncompressed or compressed with lossless JPEG
    raw: PathBuf,
    /// Picture to write: .exr or .npy (linear sRGB), .png, .jpg or .tif
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Light that is white in the picture: that of the file (default), a colour temperature such as 3200K, D65, A,
    /// chromaticities x,y, or auto, the mean colour of the picture
    #[arg(
        long,
        value_name = "as-shot|K|x,y|auto",
        value_parser = raw_white_balance,
        default_value = "as-shot",
        hide_default_value = true
    )]
    white_balance: WhiteBalance,
    /// Brightness of PNG, JPEG and TIFF in stops, such as -1.5 or 2EV, or auto. 0, the default, shows the
    /// white of the file as white
    #[arg(long, value_name = "EV|auto", allow_hyphen_values = true, help_heading = "Picture")]
    exposure: Option<DisplayExposure>,
    #[command(flatten)]
    file: FileArguments,
}

pub(super) fn run(arguments: &DevelopArguments) -> Result<Outcome, Failure> {
    let DevelopArguments { raw, output, white_balance, exposure, file } = arguments;
    let format = ImageFormat::of(output)?;
    if format == ImageFormat::Dng {
        return Err(format!(
            "{}: a DNG holds no developed picture; name a picture.png, .tif, .jpg or .exr",
            output.display()
        )
        .into());
    }
    let mut encoding = EncodingOptions {
        half: file.half,
        bit_depth: file.bit_depth,
        tone: file.tone,
        ..EncodingOptions::default()
    };
    encoding.check(output)?;
    file.warn(output, format);
    if format.is_linear() && (exposure.is_some() || file.tone != ToneCurve::Linear) {
        let name = output.display();
        say!(
            "petzval: warning: {name} has linear light: --exposure and --tone are for PNG, JPEG and TIFF"
        );
    }
    let memory = Memory::new(None);
    let context = memory.context();
    let raw_file = RawFile::read(raw, context)?;
    let target = claim_writable(&Outputs::beside(&context.files()), output, "-o")?;
    let developed = raw_file.develop(*white_balance);
    let developed = developed.map_err(|error| format!("{}: {error}", path_excerpt(raw)))?;
    if !developed.left_out.is_empty() {
        let names = developed.left_out.join(", ");
        say!("petzval: warning: {} asks for corrections that are left out: {names}", raw.display());
    }
    let exposure = exposure.unwrap_or_default();
    encoding.exposure = DisplayExposure::by(exposure.factor(&developed.picture));
    encoding.grey = developed.white.is_none();
    let mut notes = vec![("commandLine", Note::Text(shell_line(&argv())))];
    if let DisplayExposure::Stops(stops) = encoding.exposure
        && !format.is_linear()
    {
        notes.push(("displayExposure", Note::Number(stops)));
        if exposure == DisplayExposure::Auto {
            say!("petzval: exposure {stops:.2} EV");
        }
    }
    let [width, height] = developed.picture.size;
    let white = match developed.white {
        Some([x, y]) => {
            notes.push(("rawWhite", Note::Text(format!("{x:.4},{y:.4}"))));
            format!("white is light of {x:.4},{y:.4}")
        }
        None => "a sensor without filters".to_owned(),
    };
    let window = PictureWindow { origin: [0, 0], frame: developed.picture.size.map(|n| n as u32) };
    developed.picture.write(&target, window, encoding, &notes)?;
    say!("petzval: {}: {width} x {height} pixels, {white}", output.display());
    Ok(Outcome::Done)
}
