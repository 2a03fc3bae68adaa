//! Coatings: the tables `[[coating]]`, and the key `coating` of a surface.

use std::fmt::Write as _;
use std::sync::Arc;

use super::medium;
use super::value::Section;
use super::write::{medium as write_medium, string};
use petzval_base::io::{excerpt, hint};
use petzval_lens::LensError;
use petzval_lens::{Coating, CoatingLayer, LayerStack};
use petzval_lens::{Prescription, Row};
use petzval_spectrum::GlassLibrary;

/// Reads the stacks that a file defines.
pub(super) fn definitions(top: &Section) -> Result<Vec<LayerStack>, LensError> {
    let expected = "expected [[coating]] before name and layers of each coating";
    let mut stacks: Vec<LayerStack> = Vec::new();
    for section in top.tables("coating", expected)? {
        let stack = definition(&section)?;
        if stacks.iter().any(|known| known.name.eq_ignore_ascii_case(&stack.name)) {
            let found = format!("a second coating \"{}\"", excerpt(&stack.name));
            return Err(section.error("name", found, "expected each name once"));
        }
        stacks.push(stack);
    }
    Ok(stacks)
}

fn definition(section: &Section) -> Result<LayerStack, LensError> {
    section.reject_unknown_keys(&["name", "layers"])?;
    let expected = "expected a name to which surfaces refer";
    let Some(name) = section.string("name")?.filter(|name| !name.trim().is_empty()) else {
        return Err(section.error("name", "a coating without a name", expected));
    };
    if Coating::named(name).is_some() {
        let found = format!("a coating with the name \"{}\"", excerpt(name));
        let expected = format!("expected another name than {}", Coating::NAMES.join(", "));
        return Err(section.error("name", found, expected));
    }
    let expected =
        "expected layers = [{ glass = \"MGF2\", thickness = nm }, ...], from air to glass";
    let layers = section.tables("layers", expected)?;
    let most = LayerStack::MAX_LAYERS;
    match layers.len() {
        0 => return Err(section.error("layers", "a coating without layers", expected)),
        count if count > most => {
            let found = format!("{count} layers of a coating");
            return Err(section.error("layers", found, format!("expected {most} at most")));
        }
        _ => (),
    }
    Ok(LayerStack {
        name: name.into(),
        layers: layers.iter().map(layer).collect::<Result<_, _>>()?,
    })
}

fn layer(section: &Section) -> Result<CoatingLayer, LensError> {
    section.reject_unknown_keys(&["thickness", "glass", "index", "abbe", "formula"])?;
    let least = LayerStack::MIN_INDEX;
    let Some((index, glass)) = medium::stated(section)? else {
        let expected = "expected glass or index beside thickness";
        return Err(section.error("glass", "a layer without a material", expected));
    };
    if index < least {
        let key = if section.has("index") { "index" } else { "glass" };
        let expected = format!("expected {least} or more: a film is denser than air and water");
        return Err(section.error(key, format!("a layer of index {index}"), expected));
    }
    let expected =
        format!("expected a thickness in nm, above 0 and at most {}", LayerStack::MAX_THICKNESS);
    let Some(thickness) = section.finite("thickness")? else {
        return Err(section.error("thickness", "a layer without thickness", expected));
    };
    if !(thickness > 0.0 && thickness <= LayerStack::MAX_THICKNESS) {
        return Err(section.error("thickness", format!("thickness is {thickness}"), expected));
    }
    Ok(CoatingLayer { index, glass, thickness })
}

/// Reads the coating of a surface; `indices` are those before and behind it.
pub(super) fn of_surface(
    section: &Section,
    stacks: &[LayerStack],
    indices: [f64; 2],
) -> Result<Option<Coating>, LensError> {
    let Some(name) = section.string("coating")? else { return Ok(None) };
    let name = excerpt(name);
    let defined = stacks.iter().find(|stack| stack.name.eq_ignore_ascii_case(&name));
    let Some(coating) = defined.cloned().map(Coating::Stack).or_else(|| Coating::named(&name))
    else {
        let known: Vec<&str> =
            Coating::NAMES.into_iter().chain(stacks.iter().map(|stack| &*stack.name)).collect();
        let found = format!("coating is \"{name}\"{}", hint(&name, known.iter().copied()));
        let expected = format!("expected {}, or the name of a [[coating]]", known.join(", "));
        return Err(section.error("coating", found, expected));
    };
    let layers = !matches!(coating, Coating::Bare | Coating::Perfect);
    if layers && !Coating::applies_to(indices) {
        let found = format!("{} between indices {} and {}", coating.name(), indices[0], indices[1]);
        let expected = "leave it out: only faces of glass to air are coated";
        return Err(section.error("coating", found, expected));
    }
    Ok(Some(coating))
}

/// Writes the stacks of a lens.
pub(super) fn write(lens: &Prescription, library: &GlassLibrary, text: &mut String) {
    let mut written: Vec<&Arc<str>> = Vec::new();
    for row in &lens.rows {
        let Some(Coating::Stack(stack)) = &row.coating else { continue };
        if written.contains(&&stack.name) {
            continue;
        }
        written.push(&stack.name);
        text.push_str("\n[[coating]]\n");
        string(text, "name", &stack.name);
        for layer in &stack.layers[..] {
            let _ = write!(text, "\n[[coating.layers]]\nthickness = {:?}\n", layer.thickness);
            let medium = Row { index: layer.index, glass: layer.glass.clone(), ..Row::default() };
            write_medium(&medium, &Row::default(), library, text);
        }
    }
}
