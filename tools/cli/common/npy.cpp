#include "common/npy.hpp"

#include "common/content.hpp"
#include "common/failure.hpp"

namespace cli {

void write_npy_header(OutputFile &out, const std::vector<size_t> &shape) {
    std::string text = "{'descr': '<f8', 'fortran_order': False, 'shape': (";
    for (size_t i = 0; i < shape.size(); i++)
        text += (i > 0 ? ", " : "") + std::to_string(shape[i]);
    text += shape.size() == 1 ? ",), }" : "), }";
    std::string start("\x93NUMPY\1\0\xf6\0", 10); // version 1.0, and the size of the text that follows: 246 bytes
    text.resize(kNpyHeaderSize - start.size() - 1, ' '); // the header's size marks files of this program
    out.write((start + text + "\n").data(), kNpyHeaderSize);
}

toliman::NpyHeader read_npy_header(InputFile &file) {
    if (file.ended())
        malformed(file.path(), "is empty");
    toliman::NpyHeader header;
    const auto read = [&](void *data, size_t size) { return file.read(data, size); };
    const std::string complaint = toliman::read_npy_header(read, header);
    if (!complaint.empty())
        malformed(file.path(), complaint + (complaint == "is not a .npy file" ? kind_of(file.path()) : ""));
    return header;
}

} // namespace cli
