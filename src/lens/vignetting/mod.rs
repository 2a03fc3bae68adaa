//! Vignetting: which surface takes which share of the light of a film point.
//!
//! Rays from a film point go to points spread evenly over a part of the plane of the rear vertex
//! and count as exposure does: cos^4 / Z^2 from square film (Kolb, Mitchell & Hanrahan 1995, eq. 3),
//! from tilted film with the cosine to its own normal. A ray is lost
//! at the first row that it does not pass, on its way from the film to the scene.
//!
//! Over the rear element most rays end at the stop, even on the axis; nobody calls that
//! vignetting. What rims take is told by a twin of the lens whose rims are all opened but that of
//! the stop: of the light that passes its stop, the rows of the lens itself take their shares.

mod fate;
mod view;

use fate::{Fate, Fates, Start};
use view::View;

use super::outline::Frame;
use super::pose::Pose;
use super::prescription::Prescription;
use super::surface::{From, Surface, sequence};
use super::survey::Survey;
use super::widened::{Keep, widened};
use crate::rays::WAVE;
use crate::sampler::{Dimension, pair};

/// Which light is shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// What would pass the stop if all other rims were open and obstructions gone: what is lost
    /// of it is lost to mechanical vignetting.
    Stop,
    /// What enters the rear element.
    Rear,
}

/// What a row takes, as shares of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loss {
    /// At its rim, its obstruction, the blades or the mask of its opening.
    pub rim: f64,
    /// By total reflection, or because the ray does not meet the surface. Nothing at the stop,
    /// which books all its losses as `rim`.
    pub bent: f64,
}

impl Loss {
    /// Both together.
    pub fn share(&self) -> f64 {
        self.rim + self.bent
    }
}

/// Where the light of a film point goes; all shares add up to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    /// By row of the prescription.
    pub rows: Vec<Loss>,
    /// Share that leaves the lens.
    pub pass: f64,
    /// Irradiance of the film under a scene of radiance 1 (the integral of what a ray counts over
    /// what is seen of the pupil). Its ratio to that of the film's centre is the relative illumination.
    pub irradiance: f64,
}

/// Keeps the ledgers of a lens.
#[derive(Clone, Debug)]
pub struct Vignetting {
    lens: Prescription,
    distance: f64,
    /// How the film stands.
    pose: Pose,
    itself: Vec<Surface<f32>>,
    /// All rims opened but that of the stop.
    open: Vec<Surface<f32>>,
    view: View,
    /// Where in the unit square rays aim.
    points: Vec<[f32; 2]>,
}

impl Vignetting {
    /// For a film at `distance` mm behind the rear vertex. With 2^16 rays a ledger is exact to
    /// about 0.1 % of the light; a quarter of the rays, less than three times the error.
    pub fn new(lens: &Prescription, distance: f64, rays: u32) -> Self {
        Self::posed(lens, distance, Pose::SQUARE, rays)
    }

    /// The same for a film that does not stand square. Its points are told by where they stand on
    /// the film itself, mm from its middle.
    pub fn posed(lens: &Prescription, distance: f64, pose: Pose, rays: u32) -> Self {
        // Shares need no exact directions, so no ray has to be traced again in f64.
        let rough = |lens: &Prescription| {
            let mut surfaces = sequence::<f32>(lens, From::Film(distance));
            surfaces.iter_mut().for_each(|surface| surface.doubt = 0.0);
            surfaces
        };
        let open = rough(&widened(lens, Keep::Stop));
        Self {
            lens: lens.clone(),
            distance,
            pose,
            itself: rough(lens),
            view: View::new(lens, distance, &open),
            open,
            points: (0..rays.max(1)).map(|i| pair(0, i, Dimension::Pupil)).collect(),
        }
    }

    /// Where the light of a film point goes, mm; nothing where there is no such light.
    pub fn ledger(&self, film: [f64; 2], of: Of) -> Option<Ledger> {
        let (start, mut fates) = (self.start(film), Fates::default());
        let frame = match of {
            Of::Stop => self.view.frame(start, &mut fates)?,
            Of::Rear => self.rear(start),
        };
        let (middle, size) = (frame.middle(), frame.size());
        let mut books = Books::new(&self.lens, of);
        let mut open = Fates::default();
        for wave in self.points.chunks(WAVE) {
            let at = |i: usize| {
                [0, 1].map(|axis| middle[axis] + (f64::from(wave[i][axis]) - 0.5) * size[axis])
            };
            let open = open.of(start, wave.len(), at, &self.open);
            let itself = fates.of(start, wave.len(), at, &self.itself);
            for (i, (open, itself)) in open.iter().zip(itself).enumerate() {
                books.enter(start.light(at(i)), *open, *itself);
            }
        }
        books.close(size[0] * size[1] / self.points.len() as f64)
    }

    /// The angle to the axis, degrees, of the chief ray of the point (x, 0) of the film: the one
    /// through the middle of the stop, whatever rims are in its way. Nothing where no ray goes
    /// there, or where it does not come out to the scene.
    pub fn field_angle(&self, x: f64) -> Option<f64> {
        let start = self.start([x, 0.0]);
        let frame = self.view.frame(start, &mut Fates::default())?;
        self.view.chief_angle(start, frame)
    }

    /// How far from the axis along x the light ends, mm, if it does before `reach`: to a part in
    /// ten thousand of `reach`, as far as the rays find the last sliver of light.
    pub fn end(&self, reach: f64) -> Option<f64> {
        let lit = |x: f64| self.ledger([x, 0.0], Of::Stop).is_some_and(|ledger| ledger.pass > 0.0);
        if lit(reach) {
            return None;
        }
        // Light may fade in rings, but it ends once.
        let steps = 24;
        let place = |i: u32| reach * f64::from(i) / f64::from(steps);
        let last = (0..steps).rev().map(place).find(|&x| lit(x));
        let Some(mut inside) = last else { return Some(0.0) };
        let mut outside = inside + place(1);
        while outside - inside > 1e-4 * reach {
            let middle = (inside + outside) / 2.0;
            if lit(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        Some(inside)
    }

    fn start(&self, film: [f64; 2]) -> Start {
        Start {
            film: self.pose.film_point(film),
            normal: self.pose.film_normal(),
            distance: self.distance,
            index: self.lens.rear().index,
        }
    }

    /// A frame around the rear element as a film point sees it, in the plane of its vertex.
    fn rear(&self, start: Start) -> Frame {
        let survey =
            Survey { lens: &self.lens, others: &[], distance: self.distance, pose: self.pose };
        let frame = Frame::around(&survey.rear_outline(start.film));
        frame.grown(frame.size().map(|size| 0.01 * size))
    }
}

/// An open ledger.
struct Books {
    of: Of,
    stop: u16,
    rear: u16,
    rows: Vec<Loss>,
    all: f64,
    passed: f64,
}

impl Books {
    fn new(lens: &Prescription, of: Of) -> Self {
        let count = lens.rows.len();
        let rows = vec![Loss::default(); count];
        let (stop, rear) = (lens.stop() as u16, count as u16 - 1);
        Self { of, stop, rear, rows, all: 0.0, passed: 0.0 }
    }

    /// Books a ray by what became of it in the open twin and in the lens itself.
    fn enter(&mut self, light: f64, open: Fate, itself: Fate) {
        // Rows count from the scene: those before the stop come behind it.
        let light = match self.of {
            Of::Stop if open.alive() || open.row < self.stop => light * f64::from(open.left),
            Of::Rear if itself.row != self.rear => light,
            _ => return,
        };
        let share = match (itself.alive(), self.of) {
            (false, _) => 0.0,
            (true, Of::Stop) => f64::from(itself.left / open.left),
            (true, Of::Rear) => f64::from(itself.left),
        };
        self.all += light;
        self.passed += light * share;
        // Only the opening of the stop lets a part of a ray through.
        let row = if itself.alive() { self.stop } else { itself.row };
        let lost = light * (1.0 - share);
        let loss = &mut self.rows[usize::from(row)];
        if open.row == row && row != self.stop {
            loss.bent += lost;
        } else {
            loss.rim += lost;
        }
    }

    /// `area` is that of a ray in the plane of the rear vertex, mm^2.
    fn close(self, area: f64) -> Option<Ledger> {
        let Self { rows, all, passed, .. } = self;
        let share = |loss: Loss| Loss { rim: loss.rim / all, bent: loss.bent / all };
        (all > 0.0).then(|| Ledger {
            rows: rows.into_iter().map(share).collect(),
            pass: passed / all,
            irradiance: passed * area,
        })
    }
}
