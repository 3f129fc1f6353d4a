#include "recording/hdf5_id.h"

namespace tandem::recording {
namespace {

herr_t remember_innermost(unsigned, const H5E_error2_t* error, void* data) {
  auto& cause = *static_cast<std::string*>(data);
  if (error->desc == nullptr) return 0;
  const std::string text = error->desc;
  // The file driver writes "file write failed: time = ..., errno = 28, error message = 'No space
  // left on device', ..."; only the quoted part says anything to a person.
  constexpr const char* kQuote = "error message = '";
  const std::size_t quote = text.find(kQuote);
  if (quote != std::string::npos) {
    const std::size_t from = quote + std::string(kQuote).size();
    cause = text.substr(from, text.find('\'', from) - from);
    return 1;  // found: no need to walk on
  }
  if (cause.empty()) cause = text;
  return 0;
}

hid_t scalar_space() { return H5Screate(H5S_SCALAR); }

template <typename Value>
void write_scalar(hid_t where, const char* name, hid_t type, const Value& value) {
  const Hdf5Id space(scalar_space(), name);
  const Hdf5Id attribute(H5Acreate2(where, name, type, space, H5P_DEFAULT, H5P_DEFAULT), name);
  require(H5Awrite(attribute, type, &value) >= 0, name);
}

template <typename Value>
Value read_scalar(hid_t where, const char* name, hid_t type) {
  const Hdf5Id attribute(H5Aopen(where, name, H5P_DEFAULT), name);
  Value value{};
  require(H5Aread(attribute, type, &value) >= 0, name);
  return value;
}

Hdf5Id string_type(std::size_t size) {
  Hdf5Id type(H5Tcopy(H5T_C_S1), "string type");
  H5Tset_size(type, size == 0 ? 1 : size);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

}  // namespace

std::string hdf5_cause() {
  std::string cause;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, remember_innermost, &cause);
  return cause.empty() ? "unknown HDF5 error" : cause;
}

void write_attribute(hid_t where, const char* name, const std::string& text) {
  const Hdf5Id type = string_type(text.size());
  const Hdf5Id space(scalar_space(), name);
  const Hdf5Id attribute(H5Acreate2(where, name, type, space, H5P_DEFAULT, H5P_DEFAULT), name);
  require(H5Awrite(attribute, type, text.c_str()) >= 0, name);
}
void write_attribute(hid_t where, const char* name, double value) {
  write_scalar(where, name, H5T_IEEE_F64LE, value);
}
void write_attribute(hid_t where, const char* name, std::int64_t value) {
  write_scalar(where, name, H5T_STD_I64LE, value);
}

std::string read_text(hid_t where, const char* name) {
  const Hdf5Id attribute(H5Aopen(where, name, H5P_DEFAULT), name);
  const Hdf5Id stored(H5Aget_type(attribute), name);
  const std::size_t size = H5Tget_size(stored);
  const Hdf5Id type = string_type(size);
  std::string text(size, '\0');
  require(H5Aread(attribute, type, text.data()) >= 0, name);
  text.resize(text.find_last_not_of('\0') + 1);
  return text;
}
double read_number(hid_t where, const char* name) {
  return read_scalar<double>(where, name, H5T_NATIVE_DOUBLE);
}
std::int64_t read_integer(hid_t where, const char* name) {
  return read_scalar<std::int64_t>(where, name, H5T_NATIVE_INT64);
}

}  // namespace tandem::recording
