//! Files that the page saves: scenes and final pictures.

use std::fs;
use std::path::Path;
use std::process::Command;

use petzval_image::Picture;
use serde_json::{Value, json};

use super::{Client, View, folder, root, wait_until};

/// Returns a folder with a copy of the scene dgauss.pbrt and its lens.
fn dgauss() -> tempfile::TempDir {
    let folder = folder();
    for file in [
        "scenes/dgauss.pbrt",
        "scenes/cones.pbrt",
        "scenes/grid.png",
        "lenses/double-gauss.50mm.toml",
    ] {
        let to = folder.path().join(file);
        fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        fs::copy(root().join(file), to).expect("a copy");
    }
    folder
}

/// Asks for something, and returns the answer.
fn ask(client: &mut Client, message: &Value) -> Value {
    client.send(message);
    client.hear_one(&["saved", "render", "refused"])
}

/// Runs a command line of the page, with a name for the picture.
fn run(folder: &Path, command: &str, output: &str) -> Picture {
    let command = command.strip_prefix("petzval").expect("the command");
    let line = format!("'{}' {command} -o {output}", env!("CARGO_BIN_EXE_petzval"));
    let run = Command::new("sh").args(["-c", &line]).current_dir(folder).output();
    let run = run.expect("a shell");
    assert!(run.status.success(), "{line}: {}", String::from_utf8_lossy(&run.stderr));
    Picture::read(&folder.join(output)).expect("a picture")
}

#[test]
fn a_saved_scene_shows_the_same_picture() {
    let folder = dgauss();
    let options = ["--resolution", "45x31", "--spp=4", "--effects=-diffraction"];
    let view = View::start_in(folder.path(), "dgauss.pbrt", &options);
    let mut client = view.client();
    let still = json!({ "fstop": "4", "focus": "auto@20,11", "film-shift": "1,-2" });
    let moved = json!({ "look-at": "0.1,0,-0.2,0,0.01,3", "film-tilt": "2,0", "focus": "inf" });
    for (name, changes, exact) in [("still.pbrt", still, true), ("moved.pbrt", moved, false)] {
        let seen = client.set(changes).picture;
        let saved = ask(&mut client, &json!({ "type": "save", "name": name }));
        assert_eq!(saved["file"], json!(format!("scenes/{name}")), "{saved}");
        let command = saved["command"].as_str().expect("a command");
        for replaced in ["--fstop", "--focus", "--film", "--look-at"] {
            assert!(!command.contains(replaced), "{command}");
        }
        let text = fs::read_to_string(folder.path().join("scenes").join(name)).expect("a scene");
        assert!(text.contains("Include \"cones.pbrt\"") && text.contains(command), "{text}");
        let rendered = run(folder.path(), command, "a.exr");
        let (one, other) = (seen.pixels.as_flattened(), rendered.pixels.as_flattened());
        if exact {
            assert_eq!(one, other, "{command}");
        }
        // The place of the camera is written as its inverse: roundings move rays at edges.
        let difference: f32 = one.iter().zip(other).map(|(a, b)| (a - b).abs()).sum();
        let sum: f32 = one.iter().sum();
        assert!(sum > 0.0 && difference < 0.01 * sum, "{name}: {difference} of {sum}");
    }
}

#[test]
fn files_are_written_under_plain_new_names_only() {
    let folder = dgauss();
    let view = View::start_in(folder.path(), "dgauss.pbrt", &["--resolution=24x16", "--spp=1"]);
    let mut client = view.client();
    client.finished(1);
    let before = fs::read(folder.path().join("scenes/dgauss.pbrt")).expect("a scene");
    fs::write(folder.path().join("taken.exr"), "mine").expect("a file");
    for (kind, names) in [
        ("save", ["dgauss.pbrt", "../a.pbrt", "/tmp/a.pbrt", "a.exr", ""]),
        ("render", ["taken.exr", "../a.exr", "scenes/a.exr", "a.pbrt", "--spp=1.exr"]),
    ] {
        for name in names {
            let answer = ask(&mut client, &json!({ "type": kind, "name": name }));
            assert_eq!(answer["type"], "refused", "{kind} {name}: {answer}");
        }
        client.send(&json!({ "type": kind }));
        client.hear("refused");
    }
    assert_eq!(fs::read(folder.path().join("scenes/dgauss.pbrt")).expect("a scene"), before);
    assert_eq!(fs::read(folder.path().join("taken.exr")).expect("a file"), b"mine");
    let count = |path: &str| fs::read_dir(folder.path().join(path)).expect("a folder").count();
    assert_eq!([count("."), count("scenes")], [3, 3]);
}

#[test]
fn no_file_beside_the_final_picture_is_replaced() {
    let folder = dgauss();
    let options = ["--resolution=240x160", "--spp=4000"];
    let view = View::start_in(folder.path(), "dgauss.pbrt", &options);
    let mut client = view.client();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("p.partial.exr"), "mine").expect("a file");
    let answer = ask(&mut client, &json!({ "type": "render", "name": "p.exr" }));
    assert_eq!(answer["type"], "refused", "{answer}");
    // Another's files appear while it renders.
    client.send(&json!({ "type": "render", "name": "q.exr" }));
    until(&mut client, "running");
    fs::write(path("q.partial.exr"), "mine").expect("a file");
    client.send(&json!({ "type": "cancel" }));
    let failed = loop {
        let message = client.hear("render");
        if ["cancelled", "failed"].contains(&message["status"].as_str().unwrap_or_default()) {
            break message;
        }
    };
    assert!(failed["problem"].as_str().is_some_and(|p| p.contains("exists")), "{failed}");
    for name in ["p.partial.exr", "q.partial.exr"] {
        assert_eq!(fs::read(path(name)).expect("a file"), b"mine", "{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_scene_with_a_strange_name_is_saved_as_a_scene() {
    let folder = dgauss();
    let name = "a\nWorldBegin\n.pbrt";
    let scenes = folder.path().join("scenes");
    fs::copy(scenes.join("dgauss.pbrt"), scenes.join(name)).expect("a copy");
    let view = View::start_in(folder.path(), name, &["--resolution=24x16", "--spp=1"]);
    let mut client = view.client();
    client.set(json!({ "fstop": "4" }));
    let saved = ask(&mut client, &json!({ "type": "save", "name": "saved.pbrt" }));
    assert_eq!(saved["type"], "saved", "{saved}");
    run(folder.path(), "petzval render scenes/saved.pbrt --spp 1", "saved.exr");
}

/// Waits for a status of the final render.
fn until(client: &mut Client, status: &str) -> Value {
    loop {
        let message = client.hear_one(&["render", "refused"]);
        if message["status"] == status {
            return message;
        }
        assert!(message["type"] == "render" && message["status"] != "failed", "{message}");
    }
}

#[test]
fn the_final_picture_is_that_of_the_view() {
    let folder = dgauss();
    let view = View::start_in(folder.path(), "dgauss.pbrt", &["--resolution=45x31", "--spp=4"]);
    let mut client = view.client();
    let seen = client.set(json!({ "fstop": "4", "effects": "-diffraction" })).picture;
    client.send(&json!({ "type": "render", "name": "a.exr" }));
    until(&mut client, "finished");
    let rendered = Picture::read(&folder.path().join("a.exr")).expect("a picture");
    assert_eq!(seen.pixels, rendered.pixels);
    let again = ask(&mut client, &json!({ "type": "render", "name": "a.exr" }));
    assert_eq!(again["type"], "refused", "{again}");
}

#[test]
fn a_final_render_can_be_cancelled_and_resumed() {
    let folder = dgauss();
    // Minutes of work.
    let options = ["--resolution=300x200", "--spp=100000"];
    let mut view = View::start_in(folder.path(), "dgauss.pbrt", &options);
    let mut client = view.client();
    client.next_frame();
    let render = json!({ "type": "render", "name": "a.exr" });
    let checkpoint = folder.path().join("a.exr.checkpoint");
    let mut done = 0.0;
    for _ in 0..2 {
        client.send(&render);
        let mut share = || until(&mut client, "running")["share"].as_f64().expect("a share");
        // The work of all reports before is there at the first one.
        let first = share();
        assert!(first > done, "{first} after {done}");
        done = (0..6).map(|_| share()).fold(first, f64::max);
        let second = ask(&mut client, &json!({ "type": "render", "name": "b.exr" }));
        assert_eq!(second["type"], "refused", "{second}");
        client.send(&json!({ "type": "cancel" }));
        until(&mut client, "cancelled");
        assert!(checkpoint.exists() && !folder.path().join("a.exr").exists());
        fs::remove_file(folder.path().join("a.partial.exr")).expect("the partial picture");
    }
    let first_end = fs::metadata(&checkpoint).expect("a checkpoint").modified().expect("a time");
    // The end of the view writes a checkpoint, too.
    client.send(&render);
    until(&mut client, "running");
    let signal = Command::new("kill").args(["-TERM", &view.child.id().to_string()]).status();
    assert!(signal.expect("kill").success());
    wait_until("the command to end", || view.child.try_wait().expect("a child").is_some());
    let last_end = fs::metadata(&checkpoint).expect("a checkpoint").modified().expect("a time");
    assert!(last_end > first_end);
}

#[test]
fn a_gltf_scene_is_shown_but_saved_as_a_command_only() {
    let options = ["--lens", "lenses/dgauss.50mm.dat", "--resolution=45x30", "--spp=2"];
    let view = View::start_in(root(), "boxes.gltf", &options);
    let mut client = view.client();
    let seen = client.set(json!({ "fstop": "4" })).picture;
    assert!(seen.pixels.iter().any(|pixel| pixel[1] > 0.0));
    let saved = ask(&mut client, &json!({ "type": "save", "name": "a.pbrt" }));
    assert_eq!(saved["type"], "refused", "{saved}");
    assert!(saved.to_string().contains("Save the command instead"), "{saved}");
    assert!(!root().join("scenes/a.pbrt").exists());
}
