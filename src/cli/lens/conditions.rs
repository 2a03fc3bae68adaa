//! Arguments and conditions that report, tolerance analysis and optimization share.

use std::path::Path;

use petzval_lens::Prescription;
use petzval_optics::{ConditionChoices, ImagingConditions, Refocus};
use petzval_render::prepare::settings;

use crate::cli::Failure;
use crate::cli::arguments::values::{focus_distance, length, typed};

/// Opening of the stop.
#[derive(Debug, clap::Args)]
pub(super) struct StopArguments {
    /// Stop the lens down to this diameter of the stop, such as 8mm (a number alone is in mm)
    #[arg(long, value_name = "8mm", value_parser = length, allow_hyphen_values = true)]
    stop: Option<f64>,
    /// f-number that the lens is stopped down to, such as f/8 or 8; by default the lens is wide open
    #[arg(
        long,
        value_name = "f/N",
        value_parser = typed(settings::f_number),
        allow_hyphen_values = true,
        conflicts_with = "stop"
    )]
    fstop: Option<f64>,
}

impl StopArguments {
    /// Stops the lens down.
    ///
    /// # Errors
    /// Returns an error if the lens does not open so wide, or has no f-number.
    pub fn stop_down(&self, lens: &mut Prescription) -> Result<(), Failure> {
        if let Some(stop) = self.stop {
            let open = lens.rows[lens.stop()].diameter;
            if stop > open {
                return Err(format!("--stop {stop}: expected at most {open} mm").into());
            }
            lens.stop_down(stop);
        }
        if let Some(f_number) = self.fstop {
            if let Some(rounded) = lens.rounded_f_number(f_number) {
                say!("petzval: warning: {rounded}");
            }
            let diameter = lens
                .f_number_diameter(f_number)
                .map_err(|error| format!("--fstop {f_number}: {} {error}", lens.name))?;
            lens.stop_down(diameter);
        }
        Ok(())
    }
}

/// Stop, object, film and largest field.
#[derive(Debug, clap::Args)]
pub(super) struct ConditionArguments {
    #[command(flatten)]
    stop: StopArguments,
    /// Distance of the object from the film, such as 2m, 850mm or inf, instead of that of the lens
    /// file
    ///
    /// A number alone is in metres
    #[arg(long, value_name = "2m|850mm|inf", value_parser = focus_distance)]
    focus: Option<f64>,
    /// Distance of the film behind the rear vertex, mm, instead of that of the lens file, or of the
    /// sharpest one
    #[arg(long, value_name = "MM", value_parser = length)]
    film_distance: Option<f64>,
    /// Largest image height, mm, instead of the fields of the lens file
    ///
    /// Without either, 21.63 or nearly the end of the light
    #[arg(long, value_name = "MM", value_parser = length)]
    image_height: Option<f64>,
}

/// Conditions, with fields by their shares of the largest.
#[derive(Debug, clap::Args)]
pub(super) struct FieldArguments {
    #[command(flatten)]
    conditions: ConditionArguments,
    /// Fields as shares of the largest field angle or object height
    #[arg(long, value_name = "SHARE,...", value_parser = field_shares, default_value = "0,0.7,1")]
    fields: FieldShares,
    /// Threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// Shares of the largest field, in the order of the user.
#[derive(Clone, Debug)]
pub(super) struct FieldShares(pub Vec<f64>);

/// Parses fields as shares of the largest.
pub(super) fn field_shares(text: &str) -> Result<FieldShares, String> {
    let one = |part: &str| part.trim().parse().ok().filter(|share| (0.0..=1.0).contains(share));
    let all: Option<Vec<f64>> = text.split(',').map(one).collect();
    all.map(FieldShares).ok_or_else(|| {
        "expected shares from 0 to 1 with commas between, such as 0,0.7,1".to_owned()
    })
}

impl ConditionArguments {
    /// Stops the lens down, and returns its conditions.
    pub fn conditions(
        &self,
        file: &Path,
        lens: &mut Prescription,
    ) -> Result<ImagingConditions, Failure> {
        self.stop.stop_down(lens)?;
        let choices = ConditionChoices {
            focus: self.focus,
            film_distance: self.film_distance,
            image_height: self.image_height,
        };
        let conditions = ImagingConditions::new(lens, choices)
            .map_err(|error| format!("{}: {error}", file.display()))?;
        if conditions.fields_replaced {
            say!(
                "petzval: warning: {}: no light of the file's largest field reaches the film; \
                 image heights up to {:.2} mm are used (choose with --image-height)",
                file.display(),
                conditions.largest_field
            );
        }
        Ok(conditions)
    }
}

impl FieldArguments {
    /// Stops the lens down, and returns its conditions.
    pub fn conditions(
        &self,
        file: &Path,
        lens: &mut Prescription,
    ) -> Result<ImagingConditions, Failure> {
        self.conditions.conditions(file, lens)
    }

    /// Returns the shares of the largest field.
    pub fn shares(&self) -> Vec<f64> {
        self.fields.0.clone()
    }

    /// Returns the shares of the largest field, of either sign: a decentred lens is not symmetric.
    pub fn both_signs(&self) -> Vec<f64> {
        let shares = &self.fields.0;
        let negative = shares.iter().filter(|share| **share != 0.0).map(|share| -share);
        shares.iter().copied().chain(negative).collect()
    }

    pub fn threads(&self) -> usize {
        let all = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(all, usize::from)
    }
}

/// Parses what is done to the film.
pub(super) fn refocus(text: &str) -> Result<Refocus, String> {
    match text {
        "off" => Ok(Refocus::Off),
        "axis" => Ok(Refocus::Axis),
        "fields" => Ok(Refocus::Fields),
        _ => Err("expected off, axis or fields".to_owned()),
    }
}
