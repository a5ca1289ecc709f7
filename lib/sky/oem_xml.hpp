// CCSDS Orbit Ephemeris Messages as XML.
#pragma once
#include "ingest/text_lines.hpp"

namespace toliman::sky {

// The message in key-value notation, with the line of each of its parts in the XML. Status::format, with line and
// reason, unless `text` is XML that contains one such message.
ingest::TextLines key_values_of_xml(const char *path, std::string_view text);

} // namespace toliman::sky
