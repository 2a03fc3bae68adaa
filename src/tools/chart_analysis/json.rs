//! Results as JSON, for the command and for Python.

use serde_json::{Value, json};

use super::{
    ColourPatches, DotGrid, EdgeAxis, EdgeResponse, GreyStep, GreySteps, GridDot, PatchColour,
    Shading, ShadingZone, StarResponse, StarRing, TextureResponse,
};

impl EdgeResponse {
    /// Returns the frequencies of a table (cycles a pixel): hundredths, up to one.
    pub fn frequencies() -> impl Iterator<Item = f64> {
        (0..=100).map(|i| f64::from(i) / 100.0)
    }

    /// Returns axis, slant (degrees), levels, contrast, frequencies of half and of a tenth of the contrast (cycles a
    /// pixel), rise (pixels), and the response by frequency up to one cycle a pixel.
    pub fn json(&self) -> Value {
        let frequencies: Vec<f64> = Self::frequencies().collect();
        let responses: Vec<f64> = frequencies.iter().map(|&f| self.at(f)).collect();
        json!({
            "axis": match self.axis { EdgeAxis::X => "x", EdgeAxis::Y => "y" },
            "slant_degrees": self.angle,
            "levels": self.levels,
            "contrast": self.contrast(),
            "mtf50": self.frequency_of(0.5),
            "mtf10": self.frequency_of(0.1),
            "rise_pixels": self.rise(),
            "cycles_per_pixel": frequencies,
            "response": responses,
        })
    }
}

impl TextureResponse {
    /// Returns the response by frequency (cycles a pixel).
    pub fn json(&self) -> Value {
        let column = |i: usize| self.response.iter().map(|row| row[i]).collect::<Vec<f64>>();
        json!({ "cycles_per_pixel": column(0), "response": column(1) })
    }
}

impl DotGrid {
    /// Returns middle, steps, residual (pixels), distortion at the farthest dot (%), and each dot.
    pub fn json(&self) -> Value {
        let dot = |dot: &GridDot| {
            json!({
                "index": dot.index,
                "at": dot.at,
                "distortion_percent": 100.0 * dot.distortion,
                "radius": self.radius(dot),
                "red_minus_green": dot.colour[0],
                "blue_minus_green": dot.colour[1],
                "lateral_colour": self.lateral_colour(dot),
            })
        };
        json!({
            "middle": self.middle,
            "steps": self.steps,
            "residual": self.residual,
            "distortion_percent": 100.0 * self.farthest().distortion,
            "dots": self.dots.iter().map(dot).collect::<Vec<Value>>(),
        })
    }
}

impl ColourPatches {
    /// Returns brightness relative to the chart, mean colour difference, error of the white balance in a* and b*, and
    /// each patch.
    pub fn json(&self) -> Value {
        let one = |patch: &PatchColour| {
            json!({
                "name": patch.name,
                "mean": patch.mean,
                "noise": patch.noise,
                "lab": patch.lab,
                "expected_lab": patch.expected,
                "de2000": patch.difference(),
            })
        };
        json!({
            "brightness": 1.0 / self.scale,
            "mean_de2000": self.mean_difference(),
            "max_de2000": self.worst().difference(),
            "white_balance_error": self.white_balance_error(),
            "patches": self.patches.iter().map(one).collect::<Vec<Value>>(),
        })
    }
}

impl StarResponse {
    /// Returns the centre (pixels), frequencies of half and of a tenth of the contrast (cycles a pixel), and the response
    /// by frequency: the mean, and that of each segment.
    pub fn json(&self) -> Value {
        let column = |of: fn(&StarRing) -> Value| self.rings.iter().map(of).collect::<Vec<Value>>();
        json!({
            "centre": self.centre,
            "mtf50": self.frequency_of(0.5),
            "mtf10": self.frequency_of(0.1),
            "cycles_per_pixel": column(|ring| json!(ring.frequency)),
            "response": column(|ring| json!(ring.mean())),
            "segments": column(|ring| json!(ring.segments)),
        })
    }
}

impl GreySteps {
    /// Returns the exposure (value of a reflectance of 1), the dynamic range (stops), and each step.
    pub fn json(&self) -> Value {
        let one = |step: &GreyStep| {
            json!({
                "reflectance": step.reflectance,
                "mean": step.mean,
                "value": step.value(),
                "noise": step.noise,
                "snr": step.signal_to_noise(),
                "deviation_stops": self.deviation(step),
            })
        };
        json!({
            "exposure": self.scale,
            "dynamic_range_stops": self.dynamic_range(),
            "steps": self.steps.iter().map(one).collect::<Vec<Value>>(),
        })
    }
}

impl Shading {
    /// Returns the light of the corners, the least relative to the most, the largest change of colour, and each zone, row
    /// after row.
    pub fn json(&self) -> Value {
        let one = |zone: &ShadingZone| {
            json!({
                "middle": zone.middle,
                "field": zone.field,
                "light": zone.light,
                "red_over_green": zone.colour.map(|colour| colour[0]),
                "blue_over_green": zone.colour.map(|colour| colour[1]),
            })
        };
        json!({
            "corners": self.corners().map(|zone| zone.light),
            "uniformity": self.uniformity(),
            "colour_shading": self.colour_shading(),
            "columns": self.size[0],
            "rows": self.size[1],
            "zones": self.zones.iter().map(one).collect::<Vec<Value>>(),
        })
    }
}
