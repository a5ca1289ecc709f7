#include "downlink/input_options.hpp"

namespace cli {

void add_inputs(CLI::App &command, InputOptions &input) {
    add_choice(&command, "--dtype", input.dtype, {"u16le", "u32le"});
    add_option(&command, "--roi", input.roi, "LABEL");
    command.add_option("--cadence", input.dated.cadence)->check(CLI::PositiveNumber);
    add_option(&command, "--hdu", input.dated.unit, "NAME");
    command.add_flag("--follow", input.follow);
    add_option(&command, "INPUT", input.inputs, "")->required();
}

} // namespace cli
