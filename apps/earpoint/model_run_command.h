#pragma once

namespace CLI {
class App;
}

namespace earpoint {

/// Adds `run` to `earpoint model`: raw tensors in, raw tensors out.
void add_model_run_command(CLI::App& model);

}  // namespace earpoint
