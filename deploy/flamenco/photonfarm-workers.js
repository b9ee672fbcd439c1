// A job type for Flamenco: photonfarm workers, one a task. Each joins the coordinator, works, and leaves after some hours.
// Copy it into the folder "scripts" beside flamenco-manager. Flamenco's own workers have to accept tasks of the type "misc".

const JOB_TYPE = {
    label: "photonfarm workers",
    settings: [
        { key: "coordinator", type: "string", required: true, description: "Address of the coordinator, https://HOST:8080" },
        { key: "fingerprint", type: "string", default: "", description: "sha256:… of its certificate, as it printed it" },
        { key: "token_file", type: "string", default: "", description: "File with a worker's token, readable on every machine" },
        { key: "workers", type: "int32", default: 4, description: "How many; each takes one of Flamenco's workers" },
        { key: "threads", type: "int32", default: 0, description: "Threads of each; 0 for all processors" },
        { key: "hours", type: "int32", default: 8, description: "After these they give back what they have, and their tasks are done" },
        { key: "program", type: "string", default: "photonfarm", description: "Where photonfarm is on the machines" },
    ],
};

function compileJob(job) {
    for (let number = 1; number <= job.settings.workers; number++) {
        const task = author.Task(`worker-${number}`, "misc");
        // Flamenco ends `timeout` alone, by SIGKILL. The worker then gets SIGTERM from the kernel, by setpriv, and leaves in order.
        const patience = ["--foreground", "--preserve-status", "--signal=TERM", `${job.settings.hours}h`, "setpriv", "--pdeathsig", "TERM"];
        task.addCommand(author.Command("exec", { exe: "timeout", args: patience.concat(workerCommand(job, number)) }));
        job.addTask(task);
    }
}

function workerCommand(job, number) {
    const settings = job.settings;
    const words = [settings.program, "worker", "--coordinator", settings.coordinator, "--name", `flamenco-${number}`];
    if (settings.fingerprint) words.push("--fingerprint", settings.fingerprint);
    if (settings.token_file) words.push("--token-file", settings.token_file);
    if (settings.threads > 0) words.push("--threads", `${settings.threads}`);
    return words;
}
