//! `petzval lens`

use std::fmt::Write as _;
use std::io::Write as _;

use petzval::lens::{Paraxial, marginal_f_number, read};

use super::{Failure, LensArguments, Outcome};

pub(super) fn run(arguments: &LensArguments) -> Result<Outcome, Failure> {
    let file = arguments.lens.as_deref().ok_or("name a lens file")?;
    let mut lens = read(file)?;
    let opening = lens.rows[lens.stop()].diameter;
    if let Some(stop) = arguments.stop {
        if stop > opening {
            return Err(format!("--stop {stop}: expected at most {opening} mm").into());
        }
        lens.stop_down(stop);
    }
    let paraxial = Paraxial::of(&lens);
    if arguments.vignetting {
        return print(&super::vignetting::table(&lens, &paraxial, arguments)?);
    }
    let mut text = format!("{}\n{lens}\n", lens.name);
    let mut line = |name: &str, value: f64, unit: &str| {
        let _ = writeln!(text, "{name:<28}{value:>12.4}{unit}");
    };
    line("focal length", paraxial.focal_length, " mm");
    line("f-number", paraxial.f_number(), "     (focal length / entrance pupil)");
    line("f-number, marginal ray", marginal_f_number(&lens), "     (widest bundle that passes)");
    line("back focal distance", paraxial.back_focal_distance, " mm  (rear vertex to focus)");
    line("length", paraxial.length, " mm  (front to rear vertex)");
    line("entrance pupil position", paraxial.entrance_pupil.position, " mm  (behind front vertex)");
    line("entrance pupil diameter", paraxial.entrance_pupil.diameter, " mm");
    line("exit pupil position", paraxial.exit_pupil.position, " mm  (behind rear vertex)");
    line("exit pupil diameter", paraxial.exit_pupil.diameter, " mm");
    if let Some(distance) = arguments.film_distance {
        let focus = paraxial.focus_of_film(distance);
        line("film distance", distance, " mm  (behind rear vertex)");
        if focus > 0.0 && focus.is_finite() {
            line("in focus", focus, " mm  (before front vertex)");
            line("", focus + paraxial.length + distance, " mm  (from the film)");
        } else {
            line("in focus", f64::INFINITY, ": nothing real; the film is too near");
        }
    }
    if let Some(focus) = arguments.focus {
        line("focus", focus, " mm  (from the film)");
        let distance = paraxial.film_for_focus(focus)?;
        line("film distance", distance, " mm  (behind rear vertex)");
    }
    print(&text)
}

fn print(text: &str) -> Result<Outcome, Failure> {
    match std::io::stdout().write_all(text.as_bytes()) {
        // Whoever reads has seen enough.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(Outcome::Done),
        other => Ok(other.map(|()| Outcome::Done)?),
    }
}
