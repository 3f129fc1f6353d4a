#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <hdf5.h>

namespace tandem::recording {

/// What went wrong with a recording's file: file name, cause, what to do.
class RecordingError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The innermost cause on this thread's HDF5 error stack; the operating system's words if it has
/// any ("No space left on device").
[[nodiscard]] std::string hdf5_cause();

/// Keeps HDF5 from printing its error stack, on this thread, while it lives.
class QuietHdf5 {
 public:
  QuietHdf5() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Owns one HDF5 identifier.
class Hdf5Id {
 public:
  Hdf5Id() = default;
  /// Throws RecordingError with `doing` and HDF5's cause if `id` is an error.
  Hdf5Id(hid_t id, const char* doing) : id_(id) {
    if (id_ < 0) throw RecordingError(std::string(doing) + ": " + hdf5_cause());
  }
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Hdf5Id& operator=(Hdf5Id&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Hdf5Id() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT: HDF5's functions take hid_t
  /// Closes now; false if HDF5 reports an error (a file's last flush may fail).
  [[nodiscard]] bool close() { return id_ < 0 || H5Idec_ref(std::exchange(id_, -1)) >= 0; }

 private:
  hid_t id_ = -1;
};

inline void require(bool ok, const char* doing) {
  if (!ok) throw RecordingError(std::string(doing) + ": " + hdf5_cause());
}

void write_attribute(hid_t where, const char* name, const std::string& text);
void write_attribute(hid_t where, const char* name, double value);
void write_attribute(hid_t where, const char* name, std::int64_t value);
/// Absent attributes throw RecordingError.
[[nodiscard]] std::string read_text(hid_t where, const char* name);
[[nodiscard]] double read_number(hid_t where, const char* name);
[[nodiscard]] std::int64_t read_integer(hid_t where, const char* name);

}  // namespace tandem::recording
