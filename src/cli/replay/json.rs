//! A replayed sample as JSON. Numbers that JSON lacks are strings: "NaN", "inf", "-inf".

use petzval_base::rays::Ray;
use petzval_lens::{BlockReason, Blocked, LensModel, RayPath, SurfaceCrossing};
use petzval_render::job::Job;
use petzval_render::shade::{PathOutcome, SampledLight};
use petzval_render::{PathStep, Replay, ShadowRay, SharedBand};
use serde_json::{Value, json};

pub(super) fn json(job: &Job, replay: &Replay) -> Value {
    let Replay { name, film, time, wavelengths, band, weight, ray_path, .. } = replay;
    let Replay { shared, ray, steps, radiance, value, buckets, .. } = replay;
    let middles = job.buckets().map(|shares| shares.buckets().middles());
    let wavelength = match (band, &job.camera.model) {
        (Some(band), LensModel::Real(lens)) => Some(lens.bands[*band].wavelength),
        _ => None,
    };
    json!({
        "pixel": name.pixel(),
        "sample": name.sample,
        "seed": name.seed,
        "film": list(film),
        "time": time.map(number),
        "channels_nm": wavelengths,
        "band": band,
        "wavelength_nm": wavelength,
        "weight": number(*weight),
        "lens": ray_path.as_ref().map(lens),
        "shared": shared.iter().map(share).collect::<Vec<Value>>(),
        "ray": ray.as_ref().map(|(ray, throughput)| ray_json(ray, throughput)),
        "surfaces": steps.iter().map(step).collect::<Vec<Value>>(),
        "radiance": list(radiance),
        "buckets_nm": middles,
        "buckets": list(buckets),
        "value": value.as_ref().map(|value| list(value)),
        "first_not_finite": replay.first_non_finite().map(super::describe),
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

fn ray_json(ray: &Ray, throughput: &[f32; 3]) -> Value {
    json!({
        "origin": list(&ray.origin),
        "direction": list(&ray.direction),
        "carries": list(throughput),
    })
}

fn lens(path: &RayPath) -> Value {
    let RayPath { start, direction, weight, retraced, crossings, end } = path;
    let crossing = |crossing: &SurfaceCrossing| {
        let SurfaceCrossing {
            row,
            kind,
            point,
            height,
            semi_diameter,
            incidence,
            index,
            transmittance,
        } = crossing;
        json!({
            "surface": row + 1,
            "kind": kind,
            "at": point.as_ref().map(|point| list(point)),
            "height": height.map(number),
            "clear": number(*semi_diameter),
            "angle": incidence.map(number),
            "index": list(index),
            "passes": transmittance.map(number),
        })
    };
    let ends = end.as_ref().err().map(|Blocked { row, reason }| {
        let reason = match reason {
            BlockReason::Clip => "clip",
            BlockReason::Stop => "stop",
            BlockReason::Miss => "miss",
            BlockReason::Tir => "tir",
        };
        json!({ "surface": row + 1, "why": reason })
    });
    json!({
        "from": list(start),
        "towards": list(direction),
        "weight": number(*weight),
        "in_f64": retraced,
        "surfaces": crossings.iter().map(crossing).collect::<Vec<Value>>(),
        "ends": ends,
    })
}

fn share(shared: &SharedBand) -> Value {
    let reprojection = shared.reprojection;
    json!({
        "wavelength_nm": shared.wavelength,
        "film": reprojection.map(|(film, _)| list(&film)),
        "share": reprojection.map(|(_, share)| number(share)),
    })
}

fn step(step: &PathStep) -> Value {
    let PathStep {
        ray,
        throughput,
        hit,
        surface,
        collision,
        emitted_radiance,
        emission,
        record,
        shadow,
        next,
        radiance,
    } = step;
    let light = record.light.map(|SampledLight { light, pdf, radiance }| {
        json!({
            "light": light,
            "density": number(pdf),
            "radiance_over_density": list(&radiance),
        })
    });
    let shadow = shadow.map(|ShadowRay { ray, contribution, unoccluded }| {
        json!({
            "direction": list(&ray.direction),
            "t_max": number(ray.t_max),
            "brings": list(&contribution),
            "arrives": unoccluded,
        })
    });
    let outcome = match record.outcome {
        PathOutcome::Continues => "goes on",
        PathOutcome::Escapes => "escapes",
        PathOutcome::DepthLimit => "deepest",
        PathOutcome::Absorbed => "absorbed",
        PathOutcome::Complete => "complete",
        PathOutcome::Roulette { .. } => "roulette",
    };
    json!({
        "ray": ray_json(ray, throughput),
        "distance": number(hit.t),
        "shape": surface.map(|_| hit.shape),
        "primitive": surface.map(|_| hit.primitive),
        "kind": record.kind,
        "material": record.material,
        "medium": collision.map(|collision| collision.medium),
        "at": surface.map(|[at, _]| list(&at)).or(collision.map(|collision| list(&collision.at))),
        "normal": surface.map(|[_, normal]| list(&normal)),
        "shading_normal": record.normal.map(|normal| list(&normal)),
        "emits": list(emitted_radiance),
        "emission_adds": list(emission),
        "light": light,
        "shadow": shadow,
        "radiance": list(radiance),
        "fate": outcome,
        "next": next.as_ref().map(|(ray, throughput, _)| ray_json(ray, throughput)),
        "next_density": next.map(|(_, _, density)| number(density)),
    })
}
