//! Verdicts on camera models, and the recommendation of one.

use std::time::Duration;

use petzval_optics::FilmError;
use petzval_tools::accuracy::{Bias, Ladder, LadderRun, RelativeTime, Rung};

/// Visibility threshold of a model's own relative error, root mean square: Weber's fraction, as for
/// veiling light in a plan.
const VISIBLE: f64 = 0.01;

/// Visibility threshold of a ray's displacement (pixels), as in a plan.
const VISIBLE_PIXELS: f64 = 0.5;

/// Least relative difference of the light on the film that a verdict mentions.
const MIN_BRIGHTNESS: f64 = 0.02;

/// Longest budget that the advice suggests: a day (s).
const MAX_BUDGET: f64 = 86_400.0;

/// The verdict on a rung.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Index of the rung in the ladder.
    pub rung: usize,
    /// Time for the same number of samples, relative to the rung that renders use.
    pub time: Option<RelativeTime>,
    /// Whether its error, or the effect that it adds, is visible; `None` if noise hides the answer.
    pub visible: Option<bool>,
    /// Factor on the samples that would give an answer; 1 if there is one.
    pub more_samples: f64,
    /// The verdict in words, without the rung's name.
    pub sentence: String,
}

/// The measurements of a rung that a verdict needs.
struct Measured<'a> {
    rung: usize,
    time: Option<RelativeTime>,
    /// `None` for the richest rung, which the others are measured against.
    bias: Option<Bias>,
    film: &'a FilmError,
    /// Width of a pixel on the film (um).
    pitch: f64,
    /// Whether the rung has an effect that the richest lacks.
    adds: bool,
}

/// Judges every rung that was measured.
pub(super) fn verdicts(ladder: &Ladder, run: &LadderRun) -> Vec<Verdict> {
    let measured = |rung: usize| {
        let bias = run.last(rung)?.bias;
        if bias.is_none() && rung + 1 != ladder.rungs.len() {
            return None;
        }
        let Rung { film, adds, .. } = &ladder.rungs[rung];
        let (time, pitch, adds) = (time(ladder, run, rung), ladder.pitch(), adds.is_some());
        Some(Measured { rung, time, bias, film, pitch, adds })
    };
    (0..ladder.rungs.len()).filter_map(measured).map(|measured| verdict(&measured)).collect()
}

fn verdict(measured: &Measured) -> Verdict {
    let &Measured { rung, time, bias, film, pitch, adds } = measured;
    let words = time.map_or_else(|| "time unknown".to_owned(), |time| time.words());
    let answer = |visible, sentence| Verdict { rung, time, visible, more_samples: 1.0, sentence };
    let Some(bias) = bias else {
        return answer(Some(false), format!("{words}; the others are measured against it"));
    };
    let displaced = [("at the corner", film.corner_um), ("over the film", film.rms_um)]
        .map(|(place, um)| (place, um / pitch))
        .into_iter()
        .find(|(_, pixels)| !adds && pixels.is_finite() && *pixels >= VISIBLE_PIXELS);
    let percent = |share: f64| format!("{} %", two_digits(100.0 * share));
    let (size, bound) = (percent(bias.size()), bias.at_most().max(1e-6));
    if !bias.certain() {
        let (bound, more) = (percent(bound), (bound / VISIBLE).powi(2));
        let what = if adds { "a change" } else { "an error" };
        return match more < 1.0 {
            true if adds => answer(
                Some(false),
                format!(
                    "{words}, changes the picture by less than {bound}, if at all: leaving it out \
                     is not visible"
                ),
            ),
            true => answer(
                Some(false),
                format!("{words}, no visible change (less than {bound}, if any)"),
            ),
            false => {
                let sentence = format!(
                    "{words}, {what}, if any, is less than {bound} and hidden by noise; more time \
                     would tell"
                );
                Verdict { rung, time, visible: None, more_samples: more, sentence }
            }
        };
    }
    let seen = bias.size() >= VISIBLE;
    if adds {
        let not = if seen { "" } else { "not " };
        let sentence =
            format!("{words}, changes the picture by {size}: leaving it out is {not}visible");
        return answer(Some(seen), sentence);
    }
    if !seen && displaced.is_none() {
        return answer(Some(false), format!("{words}, no visible change (off by {size})"));
    }
    let mut wrong = format!("wrong by {size}");
    if let Some((place, pixels)) = displaced {
        wrong += &format!(", by {} px {place}", two_digits(pixels));
    }
    if film.light > 0.0 && (film.light - 1.0).abs() >= MIN_BRIGHTNESS {
        let side = if film.light > 1.0 { "more" } else { "less" };
        wrong += &format!(", {:.0} % {side} light", 100.0 * (film.light - 1.0).abs());
    }
    answer(Some(true), format!("{words}, {wrong}"))
}

/// Returns a rung's time relative to the usual one's, at the most samples that both have taken.
fn time(ladder: &Ladder, run: &LadderRun, rung: usize) -> Option<RelativeTime> {
    let usual = ladder.usual()?;
    let of = |rung: usize| run.points.iter().filter(move |point| point.rung == rung);
    of(rung).rev().find_map(|own| {
        let other = of(usual).find(|point| point.samples == own.samples)?;
        RelativeTime::of(own, other)
    })
}

/// Recommends a model in a sentence, with remarks in further ones; `None` if a rung was not measured.
/// `usual` is the rung that renders use. Richer rungs come after it and are never recommended for
/// their speed.
pub(super) fn recommendation(
    names: &[&str],
    usual: usize,
    verdicts: &[Verdict],
    budget: Duration,
) -> Option<String> {
    if verdicts.len() < names.len() {
        return None;
    }
    let faster = |wanted: Option<bool>| {
        let faster = |verdict: &&Verdict| verdict.time.is_some_and(|time| time.faster());
        let poorer = verdicts.iter().filter(move |verdict| verdict.rung < usual);
        poorer.filter(faster).filter(move |verdict| verdict.visible == wanted)
    };
    let unreliable = |verdict: &&Verdict| verdict.time.is_some_and(|time| !time.reliable());
    let busy = verdicts.iter().find(unreliable).is_some();
    let undecided = verdicts
        .iter()
        .filter(unreliable)
        .any(|verdict| verdict.rung < usual && verdict.visible != Some(true));
    let name = names[usual];
    let own = verdicts.iter().find(|verdict| verdict.rung == usual)?;
    let mut words = match own.visible {
        Some(true) => {
            return Some(format!(
                "{name}, which renders use, is visibly wrong here, so no model is recommended; see \
                 below."
            ));
        }
        None => {
            let more = suggestion(budget, own.more_samples);
            return Some(format!("The pictures are too noisy to choose by; {more}."));
        }
        Some(false) => {
            let time = |verdict: &Verdict| verdict.time.map_or(f64::INFINITY, |time| time.times);
            match faster(Some(false)).min_by(|a, b| time(a).total_cmp(&time(b))) {
                _ if undecided => format!(
                    "The times are not reliable, run again: the machine was busy, so that no model \
                     can be called faster than {name}."
                ),
                None => format!(
                    "Keep {name}, which renders use: no model is known to be faster here without a \
                     visible error."
                ),
                Some(best) => format!(
                    "The fastest model without a visible error here is {}, with {:.2}x the time of \
                     a render.",
                    names[best.rung],
                    time(best)
                ),
            }
        }
    };
    if busy && !undecided {
        words += " Some times are not reliable, as the machine was busy: run again for them.";
    }
    let richest = verdicts.iter().find(|v| v.rung + 1 == names.len() && v.rung > usual);
    if let Some((richest, time)) = richest.and_then(|v| Some((v, v.time.filter(|_| !busy)?)))
        && richest.visible == Some(false)
    {
        words += &format!(
            " {} takes {} and changes nothing visible.",
            names[richest.rung],
            time.words()
        );
    }
    let open: Vec<&Verdict> = faster(None).collect();
    if !open.is_empty() {
        let names: Vec<&str> = open.iter().map(|verdict| names[verdict.rung]).collect();
        let more = open.iter().map(|verdict| verdict.more_samples).fold(1.0, f64::max);
        let more = suggestion(budget, more);
        words +=
            &format!(" Not known yet: {}, faster but hidden by noise; {more}.", names.join(", "));
    }
    for verdict in verdicts.iter().filter(|v| v.rung > usual && v.visible == Some(true)) {
        words += &format!(" Visible, but not in the plan: {}.", names[verdict.rung]);
    }
    Some(words)
}

/// Suggests a budget for this many times the samples. The noise of squared errors falls in
/// proportion to them, and they double from level to level.
fn suggestion(budget: Duration, more: f64) -> String {
    let seconds = budget.as_secs_f64() * more.max(1.5).log2().ceil().exp2();
    match seconds <= MAX_BUDGET {
        true => format!("--budget {}s might tell", two_digits(seconds)),
        false => "not even a day might tell".to_owned(),
    }
}

/// Formats a number with two significant digits, or all digits before the decimal point.
pub(super) fn two_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value:.0}");
    }
    let places = (1 - value.abs().log10().floor() as i32).clamp(0, 9);
    format!("{value:.*}", places as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIME: RelativeTime = RelativeTime { times: 0.5, tolerance: 0.05 };

    /// An error of this share of the light, this many standard errors from 0.
    fn error(share: f64, deviations: f64) -> Option<Bias> {
        Some(Bias { square: share * share, error: share * share / deviations, deviations })
    }

    fn judged(bias: Option<Bias>, film: FilmError, adds: bool) -> (Option<bool>, String) {
        let measured = Measured { rung: 0, time: Some(TIME), bias, film: &film, pitch: 10.0, adds };
        let Verdict { visible, sentence, .. } = verdict(&measured);
        (visible, sentence)
    }

    fn film(rms_um: f64, corner_um: f64) -> FilmError {
        FilmError { rms_um, corner_um, light: 1.0, ..FilmError::default() }
    }

    #[test]
    fn an_error_is_visible_from_one_percent_on() {
        let seen = judged(error(0.011, 9.0), film(0.0, 0.0), false);
        assert_eq!(seen, (Some(true), "0.50x the time, wrong by 1.1 %".to_owned()));
        let unseen = judged(error(0.009, 9.0), film(0.0, 0.0), false);
        let words = "0.50x the time, no visible change (off by 0.90 %)";
        assert_eq!(unseen, (Some(false), words.to_owned()));
    }

    #[test]
    fn an_error_hidden_by_noise_has_no_verdict() {
        assert_eq!(judged(error(0.02, 3.0), film(0.0, 0.0), false).0, None);
        // An uncertain error that is too small to see is invisible anyway.
        let small = judged(error(0.004, 3.0), film(0.0, 0.0), false);
        assert_eq!(small.0, Some(false));
        assert!(small.1.contains("less than"), "{}", small.1);
    }

    #[test]
    fn rays_half_a_pixel_off_are_visible() {
        let at = |rms, corner| judged(error(0.002, 9.0), film(rms, corner), false);
        assert_eq!(at(4.0, 4.9).0, Some(false));
        assert!(at(4.0, 6.0).1.ends_with("wrong by 0.20 %, by 0.60 px at the corner"));
        assert!(at(7.0, 3.0).1.ends_with("wrong by 0.20 %, by 0.70 px over the film"));
    }

    #[test]
    fn lost_and_gained_light_are_told_apart() {
        let light = |light| judged(error(0.1, 9.0), FilmError { light, ..film(0.0, 0.0) }, false).1;
        assert!(light(0.9).ends_with(", 10 % less light"), "{}", light(0.9));
        assert!(light(1.1).ends_with(", 10 % more light"), "{}", light(1.1));
        assert!(light(1.01).ends_with("wrong by 10 %"), "{}", light(1.01));
    }

    #[test]
    fn a_rung_that_adds_an_effect_is_not_wrong() {
        let (visible, words) = judged(error(0.02, 9.0), film(99.0, 99.0), true);
        assert_eq!(visible, Some(true));
        assert!(words.ends_with("changes the picture by 2.0 %: leaving it out is visible"));
        let (visible, words) = judged(error(0.002, 9.0), film(99.0, 99.0), true);
        assert_eq!(visible, Some(false));
        assert!(words.ends_with("leaving it out is not visible"), "{words}");
    }

    /// The recommendation for a crude rung, the usual one and a richer one.
    fn recommended(
        crude: (f64, Option<bool>),
        usual: Option<bool>,
        rich: (f64, Option<bool>),
    ) -> String {
        let of = |(rung, (times, visible)): (usize, (f64, Option<bool>))| Verdict {
            rung,
            time: Some(RelativeTime { times, tolerance: 0.06 }),
            visible,
            more_samples: 3.0,
            sentence: String::new(),
        };
        let verdicts: Vec<Verdict> =
            [crude, (1.0, usual), rich].into_iter().enumerate().map(of).collect();
        let names = ["thick", "real f32", "real f64"];
        recommendation(&names, 1, &verdicts, Duration::from_secs(10)).expect("a recommendation")
    }

    #[test]
    fn the_fastest_model_without_a_visible_error_is_recommended() {
        let no = Some(false);
        let good = recommended((0.5, no), no, (0.4, no));
        assert!(good.starts_with("The fastest model") && good.contains("is thick, with 0.50x"));
        // Neither an equally fast model, nor a wrong one, nor a richer one is recommended.
        for crude in [(0.95, no), (0.5, Some(true)), (1.2, no)] {
            let words = recommended(crude, no, (1.4, no));
            assert_eq!(
                words,
                "Keep real f32, which renders use: no model is known to be faster here without a \
                 visible error. real f64 takes 1.40x the time and changes nothing visible."
            );
        }
    }

    #[test]
    fn an_open_verdict_names_the_budget_that_may_close_it() {
        let words = recommended((0.5, None), Some(false), (1.1, Some(false)));
        assert!(
            words.contains("Not known yet: thick") && words.contains("--budget 40s"),
            "{words}"
        );
        assert!(!recommended((1.5, None), Some(false), (1.1, Some(false))).contains("Not known"));
        assert!(recommended((0.5, None), None, (1.1, None)).contains("too noisy"));
    }

    #[test]
    fn a_busy_machine_is_no_ground_for_a_choice() {
        let of = |rung, times, tolerance, visible| Verdict {
            rung,
            time: Some(RelativeTime { times, tolerance }),
            visible: Some(visible),
            more_samples: 1.0,
            sentence: String::new(),
        };
        let names = ["thick", "real f32", "real f64"];
        let words = |crude: Verdict| {
            let verdicts = [crude, of(1, 1.0, 0.05, false), of(2, 1.1, 0.05, false)];
            recommendation(&names, 1, &verdicts, Duration::from_secs(10)).expect("advice")
        };
        let undecided = words(of(0, 0.5, 3.05, false));
        assert!(undecided.starts_with("The times are not reliable, run again"), "{undecided}");
        assert!(!undecided.contains("305"), "{undecided}");
        // The time of a model that is visibly wrong does not matter for the choice.
        let wrong = words(of(0, 0.5, 3.05, true));
        assert!(wrong.starts_with("Keep real f32") && wrong.contains("run again"), "{wrong}");
    }

    #[test]
    fn a_wrong_usual_model_is_not_blamed_on_noise() {
        let words = recommended((0.5, Some(false)), Some(true), (1.1, Some(false)));
        assert!(words.contains("visibly wrong") && !words.contains("noisy"), "{words}");
    }

    #[test]
    fn a_visible_effect_outside_the_plan_is_named() {
        let words = recommended((0.5, Some(false)), Some(false), (1.1, Some(true)));
        assert!(words.ends_with("Visible, but not in the plan: real f64."), "{words}");
    }

    #[test]
    fn two_digits_count() {
        let of = [38.4, 1234.0, 0.918, 0.000_123, 0.0, 9.96].map(two_digits);
        assert_eq!(of, ["38", "1234", "0.92", "0.00012", "0", "10.0"]);
    }
}
