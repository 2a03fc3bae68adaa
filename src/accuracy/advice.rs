//! What the numbers mean for somebody who has to choose.

use std::time::Duration;

use super::bias::Bias;
use super::climb::Climb;
use super::pace::Pace;
use super::rung::{Ladder, Rung};
use crate::lens::FilmError;

/// A model's own error, relative, root mean square, that cannot be seen if it is less: Weber's
/// fraction, as for the veils that a plan judges.
const VISIBLE: f64 = 0.01;

/// The same for how far a ray is from where it should be, pixels, as a plan has it.
const VISIBLE_PIXELS: f64 = 0.5;

/// From which difference on the light on the film is worth a word.
const BRIGHTNESS: f64 = 0.02;

/// The longest budget that is worth a word: a day, s.
const LONGEST: f64 = 86_400.0;

/// What is to be said of a rung.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Its place in the ladder.
    pub rung: usize,
    /// Its time for as many samples, beside that of the rung that renders take.
    pub pace: Option<Pace>,
    /// Whether its error can be seen, or what it adds; `None` where the noise is too large to tell.
    pub visible: Option<bool>,
    /// How many times the samples it would take to tell; 1 where it is told.
    pub more: f64,
    /// A sentence, without the rung's name.
    pub sentence: String,
}

/// What is known of a rung.
struct Known<'a> {
    rung: usize,
    pace: Option<Pace>,
    /// None for the measure of all others.
    bias: Option<Bias>,
    film: &'a FilmError,
    /// Width of a pixel, um.
    pitch: f64,
    /// Whether it has an effect that the measure lacks.
    adds: bool,
}

/// What is to be said of every rung that has a picture.
pub(super) fn verdicts(ladder: &Ladder, climb: &Climb) -> Vec<Verdict> {
    let known = |rung: usize| {
        let bias = climb.last(rung)?.bias;
        if bias.is_none() && rung + 1 != ladder.rungs.len() {
            return None;
        }
        let Rung { film, adds, .. } = &ladder.rungs[rung];
        let (pace, pitch, adds) = (pace(ladder, climb, rung), ladder.pitch(), adds.is_some());
        Some(Known { rung, pace, bias, film, pitch, adds })
    };
    (0..ladder.rungs.len()).filter_map(known).map(|known| verdict(&known)).collect()
}

fn verdict(known: &Known) -> Verdict {
    let &Known { rung, pace, bias, film, pitch, adds } = known;
    let time = pace.map_or_else(|| "time unknown".to_owned(), |pace| pace.words());
    let told = |visible, sentence| Verdict { rung, pace, visible, more: 1.0, sentence };
    let Some(bias) = bias else {
        return told(Some(false), format!("{time}; the measure of all others"));
    };
    let moved = [("at the corner", film.corner_um), ("over the film", film.rms_um)]
        .map(|(place, um)| (place, um / pitch))
        .into_iter()
        .find(|(_, pixels)| !adds && pixels.is_finite() && *pixels >= VISIBLE_PIXELS);
    let percent = |share: f64| format!("{} %", two_digits(100.0 * share));
    let (size, bound) = (percent(bias.size()), bias.at_most().max(1e-6));
    if !bias.certain() {
        let (bound, more) = (percent(bound), (bound / VISIBLE).powi(2));
        let what = if adds { "a change" } else { "an error" };
        return match more < 1.0 {
            true if adds => told(
                Some(false),
                format!(
                    "{time}, changes the picture by less than {bound}, if at all: leaving it out is not visible"
                ),
            ),
            true => {
                told(Some(false), format!("{time}, no visible change (less than {bound}, if any)"))
            }
            false => {
                let sentence = format!(
                    "{time}, {what}, if any, is less than {bound} and hidden by noise; more time \
                     would tell"
                );
                Verdict { rung, pace, visible: None, more, sentence }
            }
        };
    }
    let seen = bias.size() >= VISIBLE;
    if adds {
        let not = if seen { "" } else { "not " };
        let sentence =
            format!("{time}, changes the picture by {size}: leaving it out is {not}visible");
        return told(Some(seen), sentence);
    }
    if !seen && moved.is_none() {
        return told(Some(false), format!("{time}, no visible change (off by {size})"));
    }
    let mut wrong = format!("wrong by {size}");
    if let Some((place, pixels)) = moved {
        wrong += &format!(", by {} px {place}", two_digits(pixels));
    }
    if film.light > 0.0 && (film.light - 1.0).abs() >= BRIGHTNESS {
        let side = if film.light > 1.0 { "more" } else { "less" };
        wrong += &format!(", {:.0} % {side} light", 100.0 * (film.light - 1.0).abs());
    }
    told(Some(true), format!("{time}, {wrong}"))
}

/// A rung's time for as many samples as both have taken, beside that of the usual one.
fn pace(ladder: &Ladder, climb: &Climb, rung: usize) -> Option<Pace> {
    let usual = ladder.usual()?;
    let of = |rung: usize| climb.points.iter().filter(move |point| point.rung == rung);
    of(rung).rev().find_map(|own| {
        let other = of(usual).find(|point| point.samples == own.samples)?;
        Pace::of(own, other)
    })
}

/// What to take, in a sentence or more; `None` where not everything could be tried. `usual` is the
/// rung that renders take: those behind it are richer, and none is advised for being faster.
pub(super) fn choice(
    names: &[&str],
    usual: usize,
    verdicts: &[Verdict],
    budget: Duration,
) -> Option<String> {
    if verdicts.len() < names.len() {
        return None;
    }
    let faster = |wanted: Option<bool>| {
        let faster = |verdict: &&Verdict| verdict.pace.is_some_and(|pace| pace.faster());
        let poorer = verdicts.iter().filter(move |verdict| verdict.rung < usual);
        poorer.filter(faster).filter(move |verdict| verdict.visible == wanted)
    };
    let name = names[usual];
    let own = verdicts.iter().find(|verdict| verdict.rung == usual)?;
    let mut words = match own.visible {
        Some(true) => {
            return Some(format!(
                "{name}, as renders take it, is visibly wrong here, so none is advised; see below."
            ));
        }
        None => {
            let more = after(budget, own.more);
            return Some(format!("The pictures are too noisy to choose by; {more}."));
        }
        Some(false) => {
            let time = |verdict: &Verdict| verdict.pace.map_or(f64::INFINITY, |pace| pace.times);
            match faster(Some(false)).min_by(|a, b| time(a).total_cmp(&time(b))) {
                None => format!(
                    "No model is known to be faster here than {name} without a visible error."
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
    let open: Vec<&Verdict> = faster(None).collect();
    if !open.is_empty() {
        let names: Vec<&str> = open.iter().map(|verdict| names[verdict.rung]).collect();
        let more = after(budget, open.iter().map(|verdict| verdict.more).fold(1.0, f64::max));
        words +=
            &format!(" Not known yet: {}, faster but hidden by noise; {more}.", names.join(", "));
    }
    for verdict in verdicts.iter().filter(|v| v.rung > usual && v.visible == Some(true)) {
        words += &format!(" Visible, but not in the plan: {}.", names[verdict.rung]);
    }
    Some(words)
}

/// With which budget so many times the samples may be had: noise of squares falls as they rise, and
/// they double from level to level.
fn after(budget: Duration, more: f64) -> String {
    let seconds = budget.as_secs_f64() * more.max(1.5).log2().ceil().exp2();
    match seconds <= LONGEST {
        true => format!("it might be told with --budget {}s", two_digits(seconds)),
        false => "not even a day might tell".to_owned(),
    }
}

/// A number with two digits that count, or all before the point.
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

    const PACE: Pace = Pace { times: 0.5, tolerance: 0.05 };

    /// An error of this share of the light, as sure as that.
    fn error(share: f64, deviations: f64) -> Option<Bias> {
        Some(Bias { square: share * share, error: share * share / deviations, deviations })
    }

    fn judged(bias: Option<Bias>, film: FilmError, adds: bool) -> (Option<bool>, String) {
        let known = Known { rung: 0, pace: Some(PACE), bias, film: &film, pitch: 10.0, adds };
        let Verdict { visible, sentence, .. } = verdict(&known);
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
    fn what_noise_hides_is_not_told() {
        assert_eq!(judged(error(0.02, 3.0), film(0.0, 0.0), false).0, None);
        // Nor does it help to know that it is there, where it is too small.
        let small = judged(error(0.004, 3.0), film(0.0, 0.0), false);
        assert_eq!(small.0, Some(false));
        assert!(small.1.contains("less than"), "{}", small.1);
    }

    #[test]
    fn rays_half_a_pixel_off_are_visible_where_they_are() {
        let at = |rms, corner| judged(error(0.002, 9.0), film(rms, corner), false);
        assert_eq!(at(4.0, 4.9).0, Some(false));
        assert!(at(4.0, 6.0).1.ends_with("wrong by 0.20 %, by 0.60 px at the corner"));
        assert!(at(7.0, 3.0).1.ends_with("wrong by 0.20 %, by 0.70 px over the film"));
    }

    #[test]
    fn light_that_is_lost_or_won_has_its_side() {
        let light = |light| judged(error(0.1, 9.0), FilmError { light, ..film(0.0, 0.0) }, false).1;
        assert!(light(0.9).ends_with(", 10 % less light"), "{}", light(0.9));
        assert!(light(1.1).ends_with(", 10 % more light"), "{}", light(1.1));
        assert!(light(1.01).ends_with("wrong by 10 %"), "{}", light(1.01));
    }

    #[test]
    fn what_adds_an_effect_is_not_wrong() {
        let (visible, words) = judged(error(0.02, 9.0), film(99.0, 99.0), true);
        assert_eq!(visible, Some(true));
        assert!(words.ends_with("changes the picture by 2.0 %: leaving it out is visible"));
        let (visible, words) = judged(error(0.002, 9.0), film(99.0, 99.0), true);
        assert_eq!(visible, Some(false));
        assert!(words.ends_with("leaving it out is not visible"), "{words}");
    }

    /// What is advised of a crude rung, the usual one and a richer one.
    fn advised(
        crude: (f64, Option<bool>),
        usual: Option<bool>,
        rich: (f64, Option<bool>),
    ) -> String {
        let of = |(rung, (times, visible)): (usize, (f64, Option<bool>))| Verdict {
            rung,
            pace: Some(Pace { times, tolerance: 0.06 }),
            visible,
            more: 3.0,
            sentence: String::new(),
        };
        let verdicts: Vec<Verdict> =
            [crude, (1.0, usual), rich].into_iter().enumerate().map(of).collect();
        let names = ["thick", "real f32", "real f64"];
        choice(&names, 1, &verdicts, Duration::from_secs(10)).expect("advice")
    }

    #[test]
    fn the_fastest_without_a_visible_error_is_advised() {
        let no = Some(false);
        let good = advised((0.5, no), no, (0.4, no));
        assert!(good.starts_with("The fastest model") && good.contains("is thick, with 0.50x"));
        // What is as fast is not faster, what is wrong not advised, nor what is richer.
        for crude in [(0.95, no), (0.5, Some(true)), (1.2, no)] {
            let words = advised(crude, no, (0.4, no));
            assert_eq!(
                words,
                "No model is known to be faster here than real f32 without a visible error."
            );
        }
    }

    #[test]
    fn what_is_not_known_yet_is_named_with_the_time_that_may_tell() {
        let words = advised((0.5, None), Some(false), (1.1, Some(false)));
        assert!(
            words.contains("Not known yet: thick") && words.contains("--budget 40s"),
            "{words}"
        );
        assert!(!advised((1.5, None), Some(false), (1.1, Some(false))).contains("Not known"));
        assert!(advised((0.5, None), None, (1.1, None)).contains("too noisy"));
    }

    #[test]
    fn where_renders_are_wrong_noise_is_not_to_blame() {
        let words = advised((0.5, Some(false)), Some(true), (1.1, Some(false)));
        assert!(words.contains("visibly wrong") && !words.contains("noisy"), "{words}");
    }

    #[test]
    fn an_effect_that_is_missed_is_named() {
        let words = advised((0.5, Some(false)), Some(false), (1.1, Some(true)));
        assert!(words.ends_with("Visible, but not in the plan: real f64."), "{words}");
    }

    #[test]
    fn two_digits_count() {
        let of = [38.4, 1234.0, 0.918, 0.000_123, 0.0, 9.96].map(two_digits);
        assert_eq!(of, ["38", "1234", "0.92", "0.00012", "0", "10.0"]);
    }
}
