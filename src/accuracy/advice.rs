//! What the numbers mean for somebody who has to choose.

use super::climb::Climb;
use super::rung::Ladder;

/// A model's own error, relative, root mean square, that cannot be seen if it is less: Weber's
/// fraction, as for the veils that a plan judges.
const VISIBLE: f64 = 0.01;

/// The same for how far a ray is from where it should be, pixels, as a plan has it.
const VISIBLE_PIXELS: f64 = 0.5;

/// A model that takes a larger share of the time of a render is not faster to speak of.
const WORTH: f64 = 0.95;

/// From which difference on the light on the film is worth a word.
const BRIGHTNESS: f64 = 0.02;

/// What is to be said of a rung.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Its place in the ladder.
    pub rung: usize,
    /// Its time for as many samples, in units of that of the rung that renders take.
    pub times: Option<f64>,
    /// Whether its error can be seen; `None` where the noise is too large to tell.
    pub visible: Option<bool>,
    /// A sentence, without the rung's name.
    pub sentence: String,
}

/// What is to be said of every rung that has a picture.
pub(super) fn verdicts(ladder: &Ladder, climb: &Climb) -> Vec<Verdict> {
    (0..ladder.rungs.len()).filter_map(|rung| verdict(ladder, climb, rung)).collect()
}

fn verdict(ladder: &Ladder, climb: &Climb, rung: usize) -> Option<Verdict> {
    let times = times(ladder, climb, rung);
    let pace =
        times.map_or_else(|| "time unknown".to_owned(), |times| format!("{times:.2}x the time"));
    let bias = match climb.last(rung)?.bias {
        Some(bias) => bias,
        None if rung + 1 == ladder.rungs.len() => {
            let sentence = format!("{pace}; the measure of all others");
            return Some(Verdict { rung, times, visible: Some(false), sentence });
        }
        None => return None,
    };
    let film = &ladder.rungs[rung].film;
    let corner = film.corner_um.max(film.rms_um) / ladder.pitch();
    let moved = corner.is_finite() && corner >= VISIBLE_PIXELS;
    let percent = |share: f64| format!("{} %", two_digits(100.0 * share));
    let bound = bias.at_most().max(1e-6);
    let visible = match bias.certain() {
        true => Some(bias.size() >= VISIBLE || moved),
        false => (bound < VISIBLE).then_some(false),
    };
    if visible != Some(true) {
        let sentence = match visible {
            None => format!(
                "{pace}, an error, if any, is less than {} and hidden by noise; more time would tell",
                percent(bound)
            ),
            _ if bias.certain() => {
                format!("{pace}, no visible change (off by {})", percent(bias.size()))
            }
            _ => format!("{pace}, no visible change (less than {}, if any)", percent(bound)),
        };
        return Some(Verdict { rung, times, visible, sentence });
    }
    let mut wrong = format!("wrong by {}", percent(bias.size()));
    if moved {
        wrong += &format!(", by {} px at the corner", two_digits(corner));
    }
    if film.light > 0.0 && (film.light - 1.0).abs() >= BRIGHTNESS {
        let side = if film.light > 1.0 { "more" } else { "less" };
        wrong += &format!(", {:.0} % {side} light", 100.0 * (film.light - 1.0).abs());
    }
    Some(Verdict { rung, times, visible, sentence: format!("{pace}, {wrong}") })
}

/// A rung's time for as many samples as both have taken, by that of the usual one.
fn times(ladder: &Ladder, climb: &Climb, rung: usize) -> Option<f64> {
    let usual = ladder.usual()?;
    let of = |rung: usize| climb.points.iter().filter(move |point| point.rung == rung);
    of(rung).rev().find_map(|own| {
        let other = of(usual).find(|point| point.samples == own.samples)?;
        (other.seconds > 0.0).then(|| own.seconds / other.seconds)
    })
}

/// What to take, in a sentence.
pub(super) fn choice(ladder: &Ladder, verdicts: &[Verdict]) -> Option<String> {
    if verdicts.len() < ladder.rungs.len() {
        return None;
    }
    let usual = ladder.usual()?;
    let good = || verdicts.iter().filter(|verdict| verdict.visible == Some(false));
    if !good().any(|verdict| verdict.rung == usual) {
        let more = "The pictures are too noisy to choose by; give it more time with --budget.";
        return Some(more.to_owned());
    }
    let timed = good().filter_map(|verdict| Some((verdict, verdict.times?)));
    let (best, times) = timed.min_by(|a, b| a.1.total_cmp(&b.1))?;
    if times > WORTH {
        let name = &ladder.rungs[usual].name;
        return Some(format!("No model without a visible error is faster here than {name}."));
    }
    let name = &ladder.rungs[best.rung].name;
    Some(format!(
        "The fastest model without a visible error here is {name}, with {times:.2}x the time of a \
         render."
    ))
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

    #[test]
    fn two_digits_count() {
        let of = [38.4, 1234.0, 0.918, 0.000_123, 0.0, 9.96].map(two_digits);
        assert_eq!(of, ["38", "1234", "0.92", "0.00012", "0", "10.0"]);
    }
}
