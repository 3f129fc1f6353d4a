#include "view/png_file.h"

#include <png.h>
#include <stdexcept>

namespace tandem::view {

void write_png(const std::string& file, const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  if (png_image_write_to_file(&header, file.c_str(), 0, image.rgb.data(), 0, nullptr) == 0)
    throw std::runtime_error("cannot write " + file + ": " + header.message);
}

Image read_png(const std::string& file) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&header, file.c_str()) == 0)
    throw std::runtime_error("cannot read " + file + ": " + header.message);
  header.format = PNG_FORMAT_RGB;
  Image image{static_cast<int>(header.width), static_cast<int>(header.height), {}};
  image.rgb.resize(PNG_IMAGE_SIZE(header));
  if (png_image_finish_read(&header, nullptr, image.rgb.data(), 0, nullptr) == 0)
    throw std::runtime_error("cannot read " + file + ": " + header.message);
  return image;
}

}  // namespace tandem::view
