//! The accuracy of the camera models, measured for the page.

use std::time::Instant;

use serde_json::{Value, json};

use super::{HANG, View};

#[test]
fn the_page_draws_the_error_while_it_is_measured() {
    let view = View::start("dgauss.pbrt", &["--resolution", "40x40", "--spp=64"]);
    let mut client = view.client();
    client.finished(1);
    for budget in [json!(1e9), json!(-1), json!("60"), Value::Null] {
        client.send(&json!({ "type": "accuracy", "budget": budget }));
        client.hear("refused");
    }
    client.send(&json!({ "type": "accuracy", "budget": 50 }));
    let (start, mut counts) = (Instant::now(), Vec::new());
    let last = loop {
        assert!(start.elapsed() < HANG, "the measurement does not end");
        let message = client.hear("accuracy");
        counts.push(message["points"].as_array().expect("points").len());
        if message["status"] != "running" {
            break message;
        }
        let second = json!({ "type": "accuracy", "budget": 50 });
        if counts.len() == 1 {
            client.send(&second);
            client.hear("refused");
        }
    };
    assert_eq!(last["status"], "finished", "{last}");
    let models = last["models"].as_array().expect("models").len();
    // It is seen before its end.
    counts.pop();
    assert!(models > 3 && counts.iter().any(|&count| count > 0), "{counts:?}");
    let points = last["points"].as_array().expect("points");
    let of = |model: usize| points.iter().filter(|point| point["model"] == model).count();
    assert!((0..models).all(|model| of(model) > 0), "{points:?}");
    for point in points {
        let [seconds, error] = ["seconds", "error"].map(|name| point[name].as_f64().expect(name));
        assert!(seconds > 0.0 && error > 0.0, "{point}");
    }
    assert!(points.iter().any(|point| point["best"] == true));
    assert!(last["verdicts"].as_array().is_some_and(|verdicts| !verdicts.is_empty()), "{last}");

    // The view goes on, and a measurement can be cancelled.
    client.set(json!({ "fstop": "5.6" }));
    client.send(&json!({ "type": "accuracy", "budget": 3600 }));
    client.hear("accuracy");
    client.send(&json!({ "type": "cancel" }));
    let start = Instant::now();
    while client.hear("accuracy")["status"] == "running" {
        assert!(start.elapsed() < HANG, "it goes on");
    }
    client.set(json!({ "fstop": "4" }));
}
