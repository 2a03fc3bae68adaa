//! Settings of a picture: one table of names, units and ranges.
//!
//! The command, the view, data sets and Python read their values by this table, so a setting has one
//! range and one meaning everywhere. A front end adds the name of the setting and the value that it
//! found to the [`SettingError`].
//!
//! ```
//! use petzval_render::prepare::settings::{PictureSetting, SettingValue, f_number};
//!
//! let value = SettingValue::Words("43mm".to_owned());
//! let assignment = PictureSetting::named("film_diagonal").expect("a setting").read(&value)?;
//! let mut changes = petzval_render::prepare::Changes::default();
//! assignment.apply(&mut changes);
//! assert_eq!(changes.film_diagonal, Some(43.0));
//! // A reader alone gives the value.
//! assert_eq!(f_number(&SettingValue::Words("f/2.8".to_owned()))?, 2.8);
//! # Ok::<(), petzval_render::prepare::settings::SettingError>(())
//! ```

mod read;
mod table;
mod unit_range;
mod value;

#[cfg(test)]
mod tests;

pub use read::{
    buckets, coating, crop, f_number, film_diagonal, film_shift, film_tilt, focus, focus_model,
    layers, light_paths, noise, passband, resolution, samples, seed, time, zoom,
};
pub use table::{Assignment, PictureSetting, SETTINGS};
pub use unit_range::{DEGREES, LENGTHS, UnitRange, Units, number_with_unit};
pub use value::{SettingError, SettingValue};
