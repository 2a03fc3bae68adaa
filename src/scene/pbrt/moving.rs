//! Shapes that move: each is an object of which one copy moves.

use glam::DAffine3;

use super::blocks::Nested;
use super::reader::Reader;
use crate::motion::Motion;

/// An object made for moving shapes. Those that follow and move alike belong to it too.
pub(super) struct Mover {
    /// The open object when it was made.
    within: Option<String>,
    transforms: [DAffine3; 2],
    object: u32,
}

impl Reader {
    /// Where a shape belongs, and by which transform it comes there; `None` where there is no
    /// place for it. What shines cannot move.
    pub(super) fn shape_place(&mut self, name: &str) -> Option<(Option<u32>, DAffine3)> {
        let transforms = self.state.ctm;
        if transforms[0] == transforms[1] {
            return Some((None, transforms[0]));
        }
        if self.state.area_light.is_some() {
            return Some((None, self.fixed_place(&format!("a {name} that shines and"))));
        }
        let same = |mover: &&Mover| mover.within == self.object && mover.transforms == transforms;
        if let Some(mover) = self.mover.as_ref().filter(same) {
            return Some((Some(mover.object), DAffine3::IDENTITY));
        }
        let flat = transforms.iter().any(|transform| !transform.inverse().is_finite());
        let Some(motion) = Motion::between(transforms).filter(|_| !flat) else {
            self.warn_here(&format!("a {name} that its transform flattens"), "it is left out");
            return None;
        };
        let object = self.builder.object();
        match self.object.as_ref().and_then(|open| self.objects.get_mut(open)) {
            Some(open) => {
                open.nested.push((Nested::Mover(object), motion));
                open.copies = open.copies.saturating_add(1);
            }
            None => self.builder.mover(object, motion),
        }
        self.mover = Some(Mover { within: self.object.clone(), transforms, object });
        Some((Some(object), DAffine3::IDENTITY))
    }
}
