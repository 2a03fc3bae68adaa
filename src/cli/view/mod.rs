//! `petzval view`: the camera in the browser.

mod accuracy_run;
mod address;
mod background;
mod blur_map;
mod engine;
mod file_name;
mod final_render;
mod frame;
mod lens_bench;
mod lens_drawer;
mod panel;
mod preparer;
mod saved_scene;
mod server;
mod settings;
mod state;
mod tev;
mod widest_stop;

use std::net::{IpAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use petzval_base::io::ByteSize;
use petzval_render::memory::machine;

use super::arguments::PictureArguments;
use super::arguments::argv::argv;
use super::memory::Memory;
use super::signals::on_stop;
use super::{Failure, Outcome, message};
use accuracy_run::AccuracyRun;
use address::{PageAddress, open_browser};
use background::Background;
use engine::Engine;
use final_render::FinalRender;
use lens_drawer::LensDrawer;
use saved_scene::SceneSaver;
use server::Server;
use settings::ViewSettings;
use state::ViewState;
use tev::TevStream;

/// Arguments of `petzval view`.
#[derive(Debug, clap::Args)]
pub(super) struct ViewArguments {
    #[command(flatten)]
    picture: PictureArguments,
    /// Folder of lens files for the lens drawer, besides that of the scene's lens; may be repeated
    #[arg(long, value_name = "FOLDER")]
    lenses: Vec<PathBuf>,
    /// Send the picture to a running tev, too
    #[arg(long, value_name = "HOST:PORT")]
    tev: Option<String>,
    /// Number of threads that render; one per core by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    threads: Option<u16>,
    /// Largest memory use, such as 8GiB or 500MB. A picture that is expected to take more is refused.
    /// By default what the machine has, and no more than is free
    #[arg(long, value_name = "SIZE")]
    memory: Option<ByteSize>,
    /// Port of the page; by default one that is free
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
    /// Serve the page at this address of the machine instead of the loopback
    ///
    /// Everybody who can reach it and knows the page's address sees the picture and can change it;
    /// nothing is encrypted
    #[arg(long, value_name = "IP", default_value = "127.0.0.1")]
    bind: IpAddr,
    /// Print the address of the page without opening a browser
    #[arg(long)]
    no_open: bool,
}

pub(super) fn run(arguments: &ViewArguments) -> Result<Outcome, Failure> {
    let memory = Memory::new(arguments.memory);
    let scene = &arguments.picture.scene;
    let description = petzval_scene_formats::read_with(scene, memory.context())?;
    message::warnings(&description.warnings);
    let settings = ViewSettings::new(&argv(), scene, &description)?;
    let drawer = LensDrawer::new(&description, &arguments.lenses)?;
    let threads = arguments.threads.map_or_else(machine::cores, usize::from);
    let saver = SceneSaver::new(scene, &description);
    let engine = Engine::new(description.clone(), settings, threads, arguments.memory)?;
    let background = Arc::new(Background::new(engine.state.clone()));
    let final_render = FinalRender {
        description: description.clone(),
        state: engine.state.clone(),
        background: background.clone(),
    };
    let accuracy =
        AccuracyRun { description, state: engine.state.clone(), background: background.clone() };

    let name = scene.display().to_string();
    let tev =
        arguments.tev.as_ref().map(|address| TevStream::connect(address, name)).transpose()?;
    let listener = TcpListener::bind((arguments.bind, arguments.port)).map_err(|error| {
        format!(
            "--bind {} --port {}: {error}; expected an address of this machine and a free port",
            arguments.bind, arguments.port
        )
    })?;
    let address = PageAddress::new(listener.local_addr()?)?;
    let stopped = Arc::new(AtomicBool::new(false));
    let state = engine.state.clone();
    stop_at_signals(stopped.clone(), state.clone(), &address);

    super::print(&format!("{address}\n"))?;
    say!("petzval: {} is in the browser at this address; Ctrl-C ends it", scene.display());
    if !arguments.no_open && !open_browser(&address) {
        say!("petzval: no browser could be started; open the address in one on this machine");
    }
    let server = Server { address, state, drawer, saver, final_render, accuracy, background };
    thread::scope(|scope| {
        scope.spawn(|| engine.run());
        if let Some(tev) = tev {
            scope.spawn(|| tev.run(&engine.state));
        }
        server.run(&listener, &stopped);
    });
    server.background.end();
    Ok(Outcome::Interrupted)
}

/// Stops the engine and the server at Ctrl-C or SIGTERM.
fn stop_at_signals(stopped: Arc<AtomicBool>, state: Arc<ViewState>, address: &PageAddress) {
    let wake = address.local();
    on_stop(move || {
        let first = !stopped.swap(true, Ordering::Relaxed);
        state.stop();
        // The server waits for connections.
        let _ = TcpStream::connect(wake);
        first
    });
}
