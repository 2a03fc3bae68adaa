//! Table of the directives and the actions that they trigger.

use super::directive_kinds::SILENT;
use super::graphics_state::Block;
use super::options::{ACCELERATOR, RENDERER, VOLUME_INTEGRATOR};
use super::reader::SceneReader;
use super::transforms::MatrixUse;
use super::{Dialect, SceneError};

/// Reads what follows the name of a directive, and applies it.
pub(super) type Action = fn(&mut SceneReader) -> Result<(), SceneError>;

/// The name and the action of every directive.
pub(super) const DIRECTIVES: &[(&str, Action)] = &[
    ("Film", SceneReader::film),
    ("Sampler", SceneReader::sampler),
    ("PixelFilter", SceneReader::pixel_filter),
    ("Camera", SceneReader::camera),
    ("Integrator", SceneReader::integrator),
    ("SurfaceIntegrator", |r| {
        // Only pbrt-v2 has this directive.
        r.dialect = Dialect::V2;
        r.integrator()
    }),
    ("VolumeIntegrator", |r| {
        r.select_or(&VOLUME_INTEGRATOR, "media of pbrt-v2 are left out").map(drop)
    }),
    ("Renderer", |r| r.select_or(&RENDERER, "there is one renderer").map(drop)),
    ("Accelerator", |r| r.select_or(&ACCELERATOR, SILENT).map(drop)),
    ("Identity", |r| {
        r.identity();
        Ok(())
    }),
    ("Translate", SceneReader::translate),
    ("Scale", SceneReader::scale),
    ("Rotate", SceneReader::rotate),
    ("LookAt", SceneReader::look_at),
    ("Transform", |r| r.matrix(MatrixUse::Replace)),
    ("ConcatTransform", |r| r.matrix(MatrixUse::Concatenate)),
    ("CoordinateSystem", SceneReader::coordinate_system),
    ("CoordSysTransform", SceneReader::use_coordinate_system),
    ("ReverseOrientation", |r| {
        r.state.reverse_orientation = !r.state.reverse_orientation;
        Ok(())
    }),
    ("ActiveTransform", SceneReader::active_transform),
    ("TransformTimes", SceneReader::transform_times),
    ("AttributeBegin", |r| r.begin_block(Block::Attribute)),
    ("AttributeEnd", |r| r.end_block(Block::Attribute)),
    ("TransformBegin", |r| r.begin_block(Block::Transform)),
    ("TransformEnd", |r| r.end_block(Block::Transform)),
    ("ObjectBegin", SceneReader::object_begin),
    ("ObjectEnd", SceneReader::object_end),
    ("ObjectInstance", SceneReader::object_instance),
    ("Include", SceneReader::include),
    ("Import", SceneReader::import),
    ("WorldBegin", SceneReader::world_begin),
    ("WorldEnd", |r| {
        if r.peek()?.is_some() {
            r.warn_unsupported("text after WorldEnd", "it is left out");
        }
        r.ended = true;
        Ok(())
    }),
    ("LightSource", SceneReader::light_source),
    ("AreaLightSource", SceneReader::area_light_source),
    ("Texture", SceneReader::texture),
    ("Material", SceneReader::material),
    ("MakeNamedMaterial", SceneReader::make_named_material),
    ("NamedMaterial", SceneReader::named_material),
    ("Shape", SceneReader::shape),
    ("MakeNamedMedium", SceneReader::make_named_medium),
    ("MediumInterface", SceneReader::medium_interface),
    // The media of pbrt-v2.
    ("Volume", |r| {
        r.string()?;
        r.params()?;
        r.warn_unsupported("Volume", "the medium is left out");
        Ok(())
    }),
    ("ColorSpace", SceneReader::colour_space),
    ("Option", SceneReader::option),
    ("Attribute", SceneReader::attribute),
];
