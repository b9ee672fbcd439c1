//! What a farm costs beside the same passes without one, and what durability costs beside a farm that forgets: processor time and wall time
//! of one job, the three ways in turn.
//!
//! ```text
//! cargo run --release --example farm_overhead -- [SCENE] [METHOD] [PASSES] [ROUNDS]
//! ```
//!
//! Takes three times ROUNDS times as long as the job, on one thread for tracing.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use photonfarm::evaluation::{ProcessStopwatch, Spent, Stopwatch, on_threads};
use photonfarm::farm::job::{JobRequest, StopRule};
use photonfarm::farm::merging::Merging;
use photonfarm::farm::prepared_scenes::prepare_scene;
use photonfarm::farm::rules::plan::Plan;
use photonfarm::farm::store::{Store, StoreLocation};
use photonfarm::farm::wire::{messages, radius};
use photonfarm::farm::{CoordinatorOptions, LocalFarm};
use photonfarm::method::{self, MethodChoice};
use photonfarm::render::Renderer;
use prost::Message;

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

struct Job {
    scene: Vec<u8>,
    method: String,
    passes: u32,
}

impl Job {
    fn stop(&self) -> StopRule {
        StopRule { passes: Some(self.passes), ..StopRule::default() }
    }

    /// The shards of the job's plan, one after the other, merged in this process.
    fn without_farm(&self) -> Outcome<Spent> {
        let scene = Arc::new(prepare_scene(&self.scene)?);
        on_threads(1, || {
            let mut watch = ProcessStopwatch::start()?;
            let choice = MethodChoice { name: self.method.clone(), parameters: serde_json::Map::new() };
            let renderer = Renderer::new(
                scene.clone(),
                &method::check(&choice, u64::from(scene.width) * u64::from(scene.height))?,
                0,
            )?;
            let never = AtomicBool::new(false);
            let pilot = renderer.pilot(&never)?;
            let renderer = renderer.guided(&pilot.guides())?;
            let declaration = renderer.declaration().clone();
            let (width, height, passes) = (scene.width, scene.height, Some(self.passes));
            let plan = Plan::new(width, height, pilot.cost_per_pass(), passes, declaration.radius_rule);
            let mut merging = Merging::new(plan, &pilot, None, declaration)?;
            let mut index = 0;
            while let Some(planned) = merging.plan.shard(index) {
                let field = merging.field_message(planned.field_epoch, planned.region).ok_or("no radii")?;
                let pixels = planned.shard.region.pixel_count(scene.width);
                let field = radius::decode(&messages::RadiusField::decode(field)?, pixels)?;
                let tally = renderer.trace(planned.shard, &field, &never)?;
                merging.add(index, tally)?;
                index += 1;
            }
            Ok(watch.spent()?)
        })?
    }

    async fn on_farm(&self, store: Store) -> Outcome<Spent> {
        // No shard is traced twice: that is what checks cost, not what the farm does.
        let options = CoordinatorOptions { check_share: 0.0, ..CoordinatorOptions::default() };
        let farm = LocalFarm::builder().options(options).store(store).start().await?;
        let scene = farm.client().add_scene(self.scene.clone()).await?.hash;
        let mut watch = ProcessStopwatch::start()?;
        let request =
            JobRequest { method: Some(self.method.clone()), stop: self.stop(), ..JobRequest::of_scene(scene) };
        let job = farm.client().submit(request).await?;
        farm.client().watch(job)?.wait_for(|status| status.state.is_final()).await?;
        farm.client().stored().await?;
        let spent = watch.spent()?;
        farm.stop().await;
        Ok(spent)
    }
}

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |index: usize, default: &str| arguments.get(index).cloned().unwrap_or_else(|| default.to_owned());
    let job = Job {
        scene: std::fs::read(argument(0, "scenes/cornell-diffuse/scene.xml"))?,
        method: argument(1, "sppm"),
        passes: argument(2, "200").parse()?,
    };
    let rounds: u32 = argument(3, "2").parse()?;
    let runtime = tokio::runtime::Runtime::new()?;
    let mut sums = [Spent { processor: 0.0, wall: 0.0 }; 3];
    for round in 1..=rounds {
        let folder = tempfile::tempdir()?;
        let spent = [
            job.without_farm()?,
            runtime.block_on(async { job.on_farm(Store::in_memory().await?).await })?,
            runtime.block_on(async { job.on_farm(Store::open(&StoreLocation::folder(folder.path())).await?).await })?,
        ];
        for ((name, spent), sum) in
            ["without a farm", "farm in memory", "durable farm"].iter().zip(spent).zip(&mut sums)
        {
            println!("round {round}, {name:14}: {:7.2} s of processor time, {:7.2} s", spent.processor, spent.wall);
            *sum = Spent { processor: sum.processor + spent.processor, wall: sum.wall + spent.wall };
        }
    }
    let percent = |a: f64, b: f64| 100.0 * (a / b - 1.0);
    let [bare, memory, durable] = sums;
    let (processor, wall) = (percent(memory.processor, bare.processor), percent(memory.wall, bare.wall));
    println!("the farm costs {processor:+.1} % of processor time and {wall:+.1} % of wall time");
    let (processor, wall) = (percent(durable.processor, memory.processor), percent(durable.wall, memory.wall));
    println!("durability costs {processor:+.1} % of processor time and {wall:+.1} % of wall time");
    Ok(())
}
