//! Directives that change the current transform.

use glam::{DAffine3, DMat3, DVec3};

use super::lexer::{Token, TokenKind};
use super::reader::SceneReader;
use super::{SceneError, suggestion_or};
use petzval_base::io::hint;
use petzval_scene::look_at_rotation;

/// The effect of a matrix on the current transform.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum MatrixUse {
    Replace,
    Concatenate,
}

impl SceneReader {
    pub(super) fn translate(&mut self) -> Result<(), SceneError> {
        let by = DVec3::from_array(self.numbers::<3>()?);
        self.concat(DAffine3::from_translation(by))
    }

    pub(super) fn scale(&mut self) -> Result<(), SceneError> {
        let by = DVec3::from_array(self.numbers::<3>()?);
        if by.cmpeq(DVec3::ZERO).any() {
            return self.refuse("Scale by 0", "a scale that flattens space cannot be undone");
        }
        self.concat(DAffine3::from_scale(by))
    }

    pub(super) fn rotate(&mut self) -> Result<(), SceneError> {
        let [angle, x, y, z] = self.numbers::<4>()?;
        let Some(axis) = DVec3::new(x, y, z).try_normalize() else {
            return self.refuse("Rotate about no axis", "expected an angle and an axis");
        };
        self.concat(DAffine3::from_axis_angle(axis, angle.to_radians()))
    }

    pub(super) fn look_at(&mut self) -> Result<(), SceneError> {
        let n = self.numbers::<9>()?;
        self.look([0, 3, 6].map(|i| DVec3::new(n[i], n[i + 1], n[i + 2])))
    }

    /// Looks from a point at a target, both in space.
    pub(super) fn look(&mut self, [eye, target, up]: [DVec3; 3]) -> Result<(), SceneError> {
        let Some(forward) = (target - eye).try_normalize() else {
            return self.refuse("LookAt from a point to itself", "expected two points");
        };
        let Some(rotation) = look_at_rotation(forward, up) else {
            return self.refuse("LookAt along its up vector", "expected another up vector");
        };
        self.concat(DAffine3::from_mat3_translation(rotation, eye).inverse())
    }

    pub(super) fn matrix(&mut self, matrix_use: MatrixUse) -> Result<(), SceneError> {
        let m = self.numbers::<16>()?;
        if m[15] == 0.0 {
            return self.refuse("a projective matrix", "expected a last row of 0 0 0 1");
        }
        if [m[3], m[7], m[11]] != [0.0; 3] {
            // Exact for lights at infinity, which have no position.
            self.warn_unsupported("a projective matrix", "its last row counts as 0 0 0 1");
        }
        let column = |i: usize| DVec3::new(m[i], m[i + 1], m[i + 2]) / m[15];
        let affine = DAffine3 {
            matrix3: DMat3::from_cols(column(0), column(4), column(8)),
            translation: column(12),
        };
        if matrix_use == MatrixUse::Replace {
            self.identity();
        }
        self.concat(affine)
    }

    pub(super) fn concat(&mut self, by: DAffine3) -> Result<(), SceneError> {
        for (ctm, active) in self.state.ctm.iter_mut().zip(self.state.active) {
            if active {
                *ctm *= by;
            }
        }
        if self.state.ctm.iter().all(|ctm| ctm.is_finite()) {
            return Ok(());
        }
        self.refuse("a transform out of range", "its elements are not finite")
    }

    pub(super) fn identity(&mut self) {
        for (ctm, active) in self.state.ctm.iter_mut().zip(self.state.active) {
            if active {
                *ctm = DAffine3::IDENTITY;
            }
        }
    }

    /// Returns the start transform, for something that cannot move. Warns if it should move: `what`
    /// names it.
    pub(super) fn fixed_transform(&mut self, what: &str) -> DAffine3 {
        let [start, end] = self.state.ctm;
        if start != end {
            self.warn_unsupported(&format!("{what} that moves"), "it stays at its start position");
        }
        start
    }

    pub(super) fn transform_times(&mut self) -> Result<(), SceneError> {
        let [start, end] = self.numbers::<2>()?;
        if start >= end {
            let found = format!("TransformTimes from {start} to {end}");
            return self.refuse(found, "expected the end after the start");
        }
        self.transform_times = [start, end];
        Ok(())
    }

    pub(super) fn coordinate_system(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        self.coordinate_systems.insert(name, self.state.ctm);
        Ok(())
    }

    pub(super) fn use_coordinate_system(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        match self.coordinate_systems.get(&name) {
            Some(ctm) => {
                self.state.ctm = *ctm;
                Ok(())
            }
            None if self.recovery.is_lost(&name) => Ok(()),
            None => {
                let hint = hint(&name, self.coordinate_systems.keys().map(String::as_str));
                let behind = suggestion_or(hint, "expected a name that CoordinateSystem defines");
                self.refuse(format!("no coordinate system \"{name}\"{behind}"), "")
            }
        }
    }

    pub(super) fn active_transform(&mut self) -> Result<(), SceneError> {
        let token = self.next()?;
        let active = match &token {
            Some(Token { kind: TokenKind::Name(name), .. }) => match name.as_str() {
                "StartTime" => Some([true, false]),
                "EndTime" => Some([false, true]),
                "All" => Some([true; 2]),
                _ => None,
            },
            _ => None,
        };
        match active {
            Some(active) => {
                self.state.active = active;
                Ok(())
            }
            None => Err(self.unexpected(token, "expected StartTime, EndTime or All")),
        }
    }
}
