//! Parameters of a sensor from its readings of uniform fields, by the methods of EMVA 1288 (release 4.0, 2021).

mod data_file;
mod evaluation;
mod field_stack;
mod high_pass;
mod json;
mod photon_transfer;

pub use evaluation::{ChannelTransfer, ListError, evaluate_file};
pub use field_stack::{FieldStack, FieldStatistics, MIN_FIELD, Variances};
pub use photon_transfer::{Deviation, Exposure, PhotonTransfer, TransferError};
