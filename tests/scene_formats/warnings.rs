//! Warnings of scene files: one of each kind, and none for what makes no difference to the picture.

use crate::support::world::{read, read_world_with_warnings};

/// Returns the messages of the warnings of a world.
fn warnings(world: &str) -> Vec<String> {
    let description = read_world_with_warnings(world);
    description.warnings.into_iter().map(|warning| warning.message).collect()
}

#[test]
fn warnings_of_one_kind_are_counted() {
    let media: String = (0..172).map(|i| format!("Volume \"m{i}\"\n")).collect();
    let found = warnings(&format!("{media}Material \"disney\""));
    assert_eq!(found.len(), 2, "{found:#?}");
    let expected = "Volume is not supported yet: the medium is left out (and 171 more like this)";
    assert_eq!(found[0], expected);
    assert!(found[1].ends_with("or of 0.5, is used"), "{found:#?}");
}

#[test]
fn warnings_that_differ_in_numbers_alone_are_of_one_kind() {
    let mesh = |odd: &str| {
        format!(
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 {odd}] \
             \"integer indices\" [0 1 2 1 2 3]\n"
        )
    };
    let two = format!("{}{}", mesh("1e39 0 0"), mesh("1e39 0 0 1e39 0 0"));
    let found = warnings(&two);
    let [message] = &found[..] else { panic!("{found:#?}") };
    assert!(message.ends_with("left out (and 1 more like this)"), "{message}");
}

#[test]
fn a_definition_that_waits_for_its_textures_is_one_warning() {
    let world = "Material \"disney\" \"texture color\" \"t\"\n\
                 Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [0.5 0.2 0.1]\nShape \"sphere\"";
    let found = warnings(world);
    let [message] = &found[..] else { panic!("{found:#?}") };
    assert!(message.ends_with("or of 0.5, is used"), "{message}");
}

#[test]
fn an_unknown_integrator_is_a_warning() {
    let description =
        read("Integrator \"guidedpath\" \"integer maxdepth\" 9 \"bool fast\" true\nWorldBegin");
    let description = description.expect("a scene");
    let [warning] = &description.warnings[..] else { panic!("{:#?}", description.warnings) };
    assert_eq!(warning.message, "Integrator \"guidedpath\" is not supported yet: path is used");
    assert!(!description.path_limits.direct_only);
    let description = read("Integrator \"pth\"\nWorldBegin").expect("a scene");
    let message = &description.warnings[0].message;
    assert!(message.ends_with("path is used; did you mean \"path\"?"), "{message}");
}

#[test]
fn what_makes_no_difference_to_the_picture_is_no_warning() {
    for text in [
        "Accelerator \"embree\" \"string quality\" \"high\"",
        "Sampler \"adaptive\" \"integer minsamples\" 4 \"integer maxsamples\" 32",
        "PixelFilter \"sinc\" \"float tau\" 2",
    ] {
        let description = read(&format!("{text}\nWorldBegin\nShape \"sphere\"")).expect(text);
        assert!(description.warnings.is_empty(), "{text}: {:#?}", description.warnings);
        if text.contains("maxsamples") {
            assert_eq!(description.samples, 32);
        }
    }
}
