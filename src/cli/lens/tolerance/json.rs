//! Results of an analysis, as JSON.

use petzval_optics::LensFigures;
use serde_json::{Value, json};

use super::ToleranceArguments;
use super::sample::{SHARES, ToleranceSample};
use super::table::limits;

/// Describes an analysis: spots and film in mm, null for a lens that forms no image.
pub(super) fn describe(sample: &ToleranceSample, arguments: &ToleranceArguments) -> String {
    let analysis = &sample.analysis;
    let names: Vec<String> = SHARES
        .iter()
        .map(|share| format!("{:.0}", 100.0 * share))
        .chain(["worst".into()])
        .collect();
    let spread = |larger: bool, figure: &dyn Fn(&LensFigures) -> f64| -> Value {
        let mut values = serde_json::Map::new();
        values.insert("nominal".to_owned(), json!(figure(&analysis.nominal)));
        if !sample.trials.is_empty() {
            let found = sample.distribution(larger, figure);
            values.extend(names.iter().cloned().zip(found.into_iter().map(|v| json!(v))));
        }
        Value::Object(values)
    };
    let fields: Vec<Value> = (0..analysis.fields().len())
        .map(|i| {
            json!({
                "field": analysis.fields()[i],
                "spot": spread(false, &|figures| figures.spots[i]),
                "mtf_x": spread(true, &|figures| figures.modulations[i][0]),
                "mtf_y": spread(true, &|figures| figures.modulations[i][1]),
            })
        })
        .collect();
    let effects: Vec<Value> = sample
        .effects
        .iter()
        .map(|effect| {
            let parameter = &analysis.parameters[effect.parameter];
            let change = |i: usize| effect.at_limits[i].spot() - analysis.nominal.spot();
            json!({
                "name": parameter.to_string(),
                "surfaces": parameter.rows.map(|row| row + 1),
                "limit": parameter.limit,
                "unit": parameter.kind.unit(),
                "spot_change": [change(0), change(1)],
                "mtf_change": effect.worst_modulation() - analysis.nominal.modulation(),
                "correlation": effect.linear,
                "correlation_with_square": effect.square,
            })
        })
        .collect();
    let ranked: Vec<Value> = sample
        .ranked
        .iter()
        .take(10)
        .map(|&trial| {
            let figures = &sample.trials[trial].figures;
            json!({ "trial": trial, "spot": figures.spot(), "mtf": figures.modulation() })
        })
        .collect();
    let conditions = analysis.conditions();
    let value = json!({
        "trials": sample.trials.len(),
        "seed": arguments.seed,
        "tolerances": limits(&arguments.limits()),
        "frequency": arguments.frequency,
        "rays": analysis.rays(),
        "wavelengths": conditions.wavelengths.iter().map(|line| line.nm).collect::<Vec<_>>(),
        "film_distance": conditions.film_distance,
        "fields": fields,
        "spot": spread(false, &LensFigures::spot),
        "mtf": spread(true, &LensFigures::modulation),
        "defocus": spread(false, &|figures| figures.defocus),
        "effects": effects,
        "worst": ranked,
    });
    format!("{value:#}\n")
}
