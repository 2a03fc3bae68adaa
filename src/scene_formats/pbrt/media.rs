//! The MakeNamedMedium and MediumInterface directives.

use std::collections::HashMap;

use glam::DAffine3;

use super::attributes::Target;
use super::directive_kinds::{Directive, SILENT, Selected, known};
use super::lexer::TokenKind;
use super::medium_coefficients::{asymmetry, coefficients, non_negative, radiance};
use super::medium_grids::{bounds, cloud, colour_field, density_field, nanovdb_field};
use super::memory::granted;
use super::params::Params;
use super::reader::SceneReader;
use super::{SceneError, suggestion_or};
use petzval_base::io::{Location, hint};
use petzval_scene::{
    Field, Homogeneous, Medium, MediumColours, MediumInterface, MediumModel, VACUUM, VaryingMedium,
};

/// The kinds of media.
#[derive(Clone, Copy)]
enum MediumKind {
    Homogeneous,
    UniformGrid,
    RgbGrid,
    Cloud,
    NanoVdb,
}

const COEFFICIENTS: [&str; 4] = ["sigma_a", "sigma_s", "scale", "g"];

static MEDIUM: Directive<MediumKind> = Directive {
    name: "MakeNamedMedium",
    target: Some(Target::Medium),
    shared: &COEFFICIENTS,
    kinds: &[
        known("homogeneous", MediumKind::Homogeneous, &["preset", "Le", "Lescale"], &[]),
        known("uniformgrid", MediumKind::UniformGrid, GRID_READS, GRID_IGNORES),
        // The name in pbrt-v3.
        known("heterogeneous", MediumKind::UniformGrid, GRID_READS, GRID_IGNORES),
        known(
            "rgbgrid",
            MediumKind::RgbGrid,
            &["nx", "ny", "nz", "p0", "p1", "Le", "Lescale"],
            &[],
        ),
        known("cloud", MediumKind::Cloud, &["density", "wispiness", "frequency", "p0", "p1"], &[]),
        known(
            "nanovdb",
            MediumKind::NanoVdb,
            &[
                "filename",
                "gridname",
                "temperaturename",
                "Lescale",
                "temperatureoffset",
                "temperaturecutoff",
                "temperaturescale",
            ],
            &[],
        ),
    ],
};

const GRID_READS: &[&str] = &[
    "density",
    "temperature",
    "temperatureoffset",
    "temperaturecutoff",
    "temperaturescale",
    "nx",
    "ny",
    "nz",
    "p0",
    "p1",
    "Le",
    "Lescale",
    "preset",
];
const GRID_IGNORES: &[(&str, &str)] = &[("gridname", SILENT)];

/// Media by name, with the location of the first use of those that are not defined yet.
#[derive(Default)]
pub(super) struct NamedMedia(HashMap<String, (u32, Option<Location>)>);

impl SceneReader {
    pub(super) fn make_named_medium(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        let mut params = self.params()?;
        let Some(kind) = params.text("type")?.map(str::to_owned) else {
            return self.refuse(
                "a medium without \"string type\"",
                "expected a kind, such as homogeneous",
            );
        };
        params.all.retain(|param| param.name != "type");
        let Selected { kind, params, .. } = self.check_kind(&MEDIUM, &kind, params)?;
        let Some(kind) = kind else { return Ok(()) };
        let medium = self.medium(kind, &params)?;
        let index = self.medium_index(&name);
        self.media.0.insert(name, (index, None));
        self.builder.replace_medium(index, medium);
        Ok(())
    }

    pub(super) fn medium_interface(&mut self) -> Result<(), SceneError> {
        let inside = self.string()?;
        let outside = match self.peek()? {
            Some(TokenKind::Text(_)) => self.string()?,
            _ => inside.clone(),
        };
        let [inside, outside] = [inside, outside].map(|name| match name.as_str() {
            "" => VACUUM,
            name => self.medium_index(name),
        });
        self.state.media = MediumInterface { inside, outside };
        Ok(())
    }

    /// Returns the index of a medium, which may be defined later: pbrt-v4 looks names up at the end
    /// of the file.
    fn medium_index(&mut self, name: &str) -> u32 {
        if let Some((index, _)) = self.media.0.get(name) {
            return *index;
        }
        let nothing =
            Homogeneous { absorption: [0.0; 3], scattering: [0.0; 3], emission: [0.0; 3] };
        let index = self.builder.add_medium(Medium::homogeneous(nothing, 0.0));
        self.media.0.insert(name.to_owned(), (index, Some(self.at.clone())));
        index
    }

    /// Reports each medium that is used by a name but never defined.
    pub(super) fn require_named_media(&mut self) {
        let of = |(name, (_, at)): (&String, &(u32, Option<Location>))| {
            at.clone().map(|at| (at, name.clone()))
        };
        let mut undefined: Vec<_> = self.media.0.iter().filter_map(of).collect();
        undefined.retain(|(_, name)| !self.recovery.is_lost(name));
        undefined.sort();
        let defined = self.media.0.iter().filter(|(_, (_, at))| at.is_none());
        let defined: Vec<String> = defined.map(|(name, _)| name.clone()).collect();
        for (at, name) in undefined {
            let hint = hint(&name, defined.iter().map(String::as_str));
            let behind = suggestion_or(hint, "expected a name that MakeNamedMedium defines");
            self.report(SceneError::at(at, format!("no medium named \"{name}\"{behind}"), ""));
        }
    }

    /// Returns the interface of a shape, if it separates two media.
    pub(super) fn shape_interface(&self) -> Option<MediumInterface> {
        let MediumInterface { inside, outside } = self.state.media;
        (inside != outside).then_some(self.state.media)
    }

    fn medium(&mut self, kind: MediumKind, params: &Params) -> Result<Medium, SceneError> {
        let g = asymmetry(params)?;
        let (model, colours) = match kind {
            MediumKind::Homogeneous => {
                let [absorption, scattering] = coefficients(params)?;
                let emission = radiance(params)?.unwrap_or([0.0; 3].into());
                let scale = non_negative(params, "Lescale", 1.0)?;
                let emission = emission.scaled([scale; 3]);
                let colours = MediumColours { absorption, scattering, emission };
                (MediumModel::Homogeneous(Homogeneous::of(&colours)), colours.if_spectral())
            }
            MediumKind::UniformGrid => {
                let (field, colours) = density_field(params)?;
                (self.in_box(params, field)?, colours.if_spectral())
            }
            MediumKind::RgbGrid => (self.in_box(params, colour_field(params)?)?, None),
            MediumKind::Cloud => {
                let (field, colours) = cloud(params)?;
                (self.in_box(params, field)?, colours.if_spectral())
            }
            MediumKind::NanoVdb => {
                let (field, colours, medium_from_unit) = nanovdb_field(params)?;
                (self.varying(params, field, &medium_from_unit)?, colours.if_spectral())
            }
        };
        Ok(Medium::new(model, g, colours))
    }

    /// Returns the medium of a field in the box from p0 to p1.
    fn in_box(&mut self, params: &Params, field: Field) -> Result<MediumModel, SceneError> {
        let [low, high] = bounds(params)?;
        let medium_from_unit = DAffine3::from_translation(low) * DAffine3::from_scale(high - low);
        self.varying(params, field, &medium_from_unit)
    }

    /// Returns the medium of a field, whose unit cube is mapped to medium space.
    fn varying(
        &mut self,
        params: &Params,
        field: Field,
        medium_from_unit: &DAffine3,
    ) -> Result<MediumModel, SceneError> {
        let unit_from_world = (self.state.ctm[0] * *medium_from_unit).inverse();
        let Some(medium) = VaryingMedium::new(field, &unit_from_world) else {
            let found = "a medium whose box or transform is flat";
            return Err(SceneError::at(params.at.clone(), found, "check p0, p1 and the transform"));
        };
        let bytes = medium.bytes() as u64;
        granted(&params.at, "the grid of a medium", self.context.claim(bytes))?;
        Ok(MediumModel::Varying(Box::new(medium)))
    }
}
