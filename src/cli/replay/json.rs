//! A replayed sample for programs. What JSON has no number for is a word: "NaN", "inf", "-inf".

use petzval::lens::{Blocked, Crossing, Model, Passage, Why};
use petzval::rays::Ray;
use petzval::render::{Job, Replay, Shadow, Shared, Step};
use petzval::shade::{Fate, Looked};
use serde_json::{Value, json};

pub(super) fn json(job: &Job, replay: &Replay) -> Value {
    let Replay { name, film, time, band, weight, passage, shared, ray, steps, radiance, value } =
        replay;
    let wavelength = match (band, &job.camera.model) {
        (Some(band), Model::Real(lens)) => Some(lens.bands[*band].wavelength),
        _ => None,
    };
    json!({
        "pixel": name.pixel(),
        "sample": name.sample,
        "seed": name.seed,
        "film": list(film),
        "time": time.map(number),
        "band": band,
        "wavelength_nm": wavelength,
        "weight": number(*weight),
        "lens": passage.as_ref().map(lens),
        "shared": shared.iter().map(share).collect::<Vec<Value>>(),
        "ray": ray.as_ref().map(|(ray, carried)| way(ray, carried)),
        "surfaces": steps.iter().map(step).collect::<Vec<Value>>(),
        "radiance": list(radiance),
        "value": value.as_ref().map(|value| list(value)),
        "first_not_finite": replay.breaks().map(super::words),
    })
}

fn number(value: impl Into<f64>) -> Value {
    let value = value.into();
    match value.is_finite() {
        true => json!(value),
        false => json!(value.to_string()),
    }
}

fn list<T: Into<f64> + Copy>(values: &[T]) -> Value {
    values.iter().map(|&value| number(value)).collect()
}

fn way(ray: &Ray, carried: &[f32; 3]) -> Value {
    json!({
        "origin": list(&ray.origin),
        "direction": list(&ray.direction),
        "carries": list(carried),
    })
}

fn lens(passage: &Passage) -> Value {
    let Passage { start, towards, weight, redone, crossings, end } = passage;
    let crossing = |crossing: &Crossing| {
        let Crossing { row, kind, at, height, clear, incidence, index, passed } = crossing;
        json!({
            "surface": row + 1,
            "kind": kind,
            "at": at.as_ref().map(|at| list(at)),
            "height": height.map(number),
            "clear": number(*clear),
            "angle": incidence.map(number),
            "index": list(index),
            "passes": passed.map(number),
        })
    };
    let ends = end.as_ref().err().map(|Blocked { row, why }| {
        let why = match why {
            Why::Clip => "clip",
            Why::Stop => "stop",
            Why::Miss => "miss",
            Why::Tir => "tir",
        };
        json!({ "surface": row + 1, "why": why })
    });
    json!({
        "from": list(start),
        "towards": list(towards),
        "weight": number(*weight),
        "in_f64": redone,
        "surfaces": crossings.iter().map(crossing).collect::<Vec<Value>>(),
        "ends": ends,
    })
}

fn share(shared: &Shared) -> Value {
    let landing = shared.landing;
    json!({
        "wavelength_nm": shared.wavelength,
        "film": landing.map(|(film, _)| list(&film)),
        "share": landing.map(|(_, share)| number(share)),
    })
}

fn step(step: &Step) -> Value {
    let Step { ray, throughput, hit, met, emits, shone, account, shadow, next, radiance } = step;
    let looked = account.looked.map(|Looked { light, density, radiance }| {
        json!({
            "light": light,
            "density": number(density),
            "radiance_over_density": list(&radiance),
        })
    });
    let shadow = shadow.map(|Shadow { ray, brings, arrives }| {
        json!({
            "direction": list(&ray.direction),
            "t_max": number(ray.t_max),
            "brings": list(&brings),
            "arrives": arrives,
        })
    });
    let fate = match account.fate {
        Fate::GoesOn => "goes on",
        Fate::Escapes => "escapes",
        Fate::Deepest => "deepest",
        Fate::Absorbed => "absorbed",
        Fate::Complete => "complete",
        Fate::Roulette { .. } => "roulette",
    };
    json!({
        "ray": way(ray, throughput),
        "distance": number(hit.t),
        "shape": met.map(|_| hit.shape),
        "primitive": met.map(|_| hit.primitive),
        "kind": account.kind,
        "material": account.material,
        "at": met.map(|[at, _]| list(&at)),
        "normal": met.map(|[_, normal]| list(&normal)),
        "shading_normal": account.normal.map(|normal| list(&normal)),
        "emits": list(emits),
        "emission_adds": list(shone),
        "light": looked,
        "shadow": shadow,
        "radiance": list(radiance),
        "fate": fate,
        "next": next.as_ref().map(|(ray, carried, _)| way(ray, carried)),
        "next_density": next.map(|(_, _, density)| number(density)),
    })
}
