//! Parameters of a sensor as JSON, for the command and for Python.

use petzval_render::sensor::Components;
use serde_json::{Value, json};

use super::{ChannelTransfer, Deviation, PhotonTransfer};

impl ChannelTransfer {
    /// Returns the parameters of the channel as JSON.
    pub fn json(&self) -> Value {
        let Self { channel, size, transfer } = self;
        let deviation = |of: Deviation, unit: f64| {
            let Components { pixel, row, column } = of.parts.scaled(unit);
            json!({ "total": unit * of.total, "pixel": pixel, "row": row, "column": column })
        };
        let PhotonTransfer { gain, dark, dark_noise, dsnu, prnu, saturation, .. } = transfer;
        json!({
            "channel": channel,
            "photosites": size,
            "exposures": transfer.exposures.len(),
            "gain": gain,
            "dark_mean": dark.mean,
            "dark_noise_electrons": deviation(*dark_noise, 1.0),
            "dark_noise_is_resolved": transfer.is_dark_noise_resolved,
            "dsnu_electrons": deviation(*dsnu, 1.0),
            "prnu_percent": deviation(*prnu, 100.0),
            "prnu_signal_electrons": transfer.prnu_signal,
            "saturation_electrons": saturation,
            "full_well_electrons": transfer.full_well,
            "threshold_electrons": transfer.threshold(),
            "quantum_efficiency": transfer.quantum_efficiency,
            "linearity_error_percent": transfer.linearity_error.map(|error| 100.0 * error),
        })
    }
}
