#include "downlink/input_options.hpp"

namespace cli {

void add_inputs(CLI::App &command, InputOptions &input) {
    add_choice(&command, "--dtype", input.dtype, {"u16le", "u32le"},
               "pixel type of raw pairs, required for them: u16le or u32le");
    add_option(
        &command, "--roi", input.roi, "LABEL",
        "use only frames of this region of raw pairs; required if the inputs have several: frames of two regions "
        "never share a state folder or a sum");
    command
        .add_option("--cadence", input.dated.cadence,
                    "seconds from frame to frame of .npy and FITS files; required if the files contain no times")
        ->check(CLI::PositiveNumber);
    add_option(
        &command, "--hdu", input.dated.unit, "NAME",
        "name or number of the HDU of FITS files, 0 for the primary one; default: CORE, or the first with pixels");
    command.add_flag("--follow", input.follow,
                     "wait for folders and pairs to grow, until stopped by SIGINT or SIGTERM");
    add_option(
        &command, "INPUT", input.inputs, "",
        "raw pairs, batches (.nc), .npy and FITS files, folders of them; - reads their names from standard input")
        ->required();
}

} // namespace cli
