#pragma once

#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include <hdf5.h>

#include "recording/hdf5_id.h"
#include "recording/record_columns.h"

/// One table of a recording: a chunked, extendible HDF5 dataset with one compound value a row, of
/// exactly the columns in use. Bits go through unchanged: the stored types are the memory's.
///
/// The first column `row` is 1 in the first row, 2 in the second. After a kill the file may claim
/// rows whose bytes had not arrived; they hold 0 there.
namespace tandem::recording {

namespace detail {

template <typename Value>
hid_t hdf5_type_of() {
  if constexpr (std::is_same_v<Value, double>) return H5T_IEEE_F64LE;
  if constexpr (std::is_same_v<Value, std::int64_t>) return H5T_STD_I64LE;
  if constexpr (std::is_same_v<Value, std::uint64_t>) return H5T_STD_U64LE;
  if constexpr (std::is_same_v<Value, std::int32_t>) return H5T_STD_I32LE;
  if constexpr (std::is_same_v<Value, std::uint32_t>) return H5T_STD_U32LE;
}

using Shape = std::pair<int, int>;

/// Lists name, unit, type and offset of every column.
struct DescribeColumns {
  struct Column {
    const char* name;
    const char* unit;
    hid_t element;
    Shape shape;  ///< {0, 0}: a single value
    std::size_t offset;
  };
  std::vector<Column> columns;
  std::size_t size = 0;

  template <typename Value>
  void one(const char* name, const char* unit, const Value&) {
    columns.push_back({name, unit, hdf5_type_of<Value>(), {0, 0}, size});
    size += sizeof(Value);
  }
  template <typename Element>
  void many(const char* name, const char* unit, Shape shape, Element&& element) {
    if (shape.first == 0 || shape.second == 0) return;
    using Value = std::remove_cvref_t<decltype(element(0, 0))>;
    columns.push_back({name, unit, hdf5_type_of<Value>(), shape, size});
    size += sizeof(Value) * static_cast<std::size_t>(shape.first * shape.second);
  }
};

struct PackColumns {
  std::byte* to;
  template <typename Value>
  void one(const char*, const char*, const Value& value) {
    std::memcpy(to, &value, sizeof(Value));
    to += sizeof(Value);
  }
  template <typename Element>
  void many(const char* name, const char* unit, Shape shape, Element&& element) {
    for (int r = 0; r < shape.first; ++r)
      for (int c = 0; c < shape.second; ++c) one(name, unit, element(r, c));
  }
};

struct UnpackColumns {
  const std::byte* from;
  template <typename Value>
  void one(const char*, const char*, Value& value) {
    std::memcpy(&value, from, sizeof(Value));
    from += sizeof(Value);
  }
  template <typename Element>
  void many(const char* name, const char* unit, Shape shape, Element&& element) {
    for (int r = 0; r < shape.first; ++r)
      for (int c = 0; c < shape.second; ++c) one(name, unit, element(r, c));
  }
};

}  // namespace detail

template <typename Record>
class RecordTable {
 public:
  static constexpr hsize_t kRowsPerChunk = 256;

  /// Makes the dataset in a file being written.
  static RecordTable create(hid_t file, const char* name, const RecordColumns& columns) {
    RecordTable table(columns);
    const Hdf5Id creation(H5Pcreate(H5P_DATASET_CREATE), name);
    require(H5Pset_chunk(creation, 1, &kRowsPerChunk) >= 0, name);
    const hsize_t none = 0, unlimited = H5S_UNLIMITED;
    const Hdf5Id space(H5Screate_simple(1, &none, &unlimited), name);
    table.dataset_ = Hdf5Id(
        H5Dcreate2(file, name, table.type_, space, H5P_DEFAULT, creation, H5P_DEFAULT), name);
    for (const auto& column : table.described_.columns) {
      write_attribute(table.dataset_, (std::string("unit of ") + column.name).c_str(),
                      std::string(column.unit));
    }
    return table;
  }

  /// Opens the dataset of a file being read; throws RecordingError if its columns are others.
  static RecordTable open(hid_t file, const char* name, const RecordColumns& columns) {
    RecordTable table(columns);
    table.dataset_ = Hdf5Id(H5Dopen2(file, name, H5P_DEFAULT), name);
    const Hdf5Id stored(H5Dget_type(table.dataset_), name);
    if (H5Tequal(stored, table.type_) <= 0) {
      throw RecordingError(std::string("table \"") + name +
                           "\" has other columns than this version of Tandem writes");
    }
    const Hdf5Id space(H5Dget_space(table.dataset_), name);
    hsize_t rows = 0;
    require(H5Sget_simple_extent_dims(space, &rows, nullptr) == 1, name);
    table.rows_ = rows;
    return table;
  }

  [[nodiscard]] std::uint64_t rows() const { return rows_; }

  void append(const std::vector<Record>& records) {
    if (records.empty()) return;
    const std::size_t size = described_.size;
    bytes_.resize(records.size() * size);
    for (std::size_t i = 0; i < records.size(); ++i) {
      detail::PackColumns pack{bytes_.data() + i * size};
      const std::uint64_t row = rows_ + i + 1;
      pack.one("row", "1", row);
      visit_columns(records[i], columns_, pack);
    }
    const hsize_t count = records.size(), total = rows_ + count;
    require(H5Dset_extent(dataset_, &total) >= 0, "extend");
    const Hdf5Id memory(H5Screate_simple(1, &count, nullptr), "rows in memory");
    const Hdf5Id space = select(rows_, count);
    require(H5Dwrite(dataset_, type_, memory, space, H5P_DEFAULT, bytes_.data()) >= 0, "write");
    rows_ = total;
  }

  /// Rows `first` to `first + count`, but no further than the last whole one.
  [[nodiscard]] std::vector<Record> read(std::uint64_t first, std::uint64_t count) {
    count = first >= rows_ ? 0 : std::min(count, rows_ - first);
    std::vector<Record> records(count);
    if (count == 0) return records;
    const std::size_t size = described_.size;
    bytes_.resize(count * size);
    const hsize_t in_memory = count;
    const Hdf5Id memory(H5Screate_simple(1, &in_memory, nullptr), "rows in memory");
    const Hdf5Id space = select(first, count);
    require(H5Dread(dataset_, type_, memory, space, H5P_DEFAULT, bytes_.data()) >= 0, "read");
    for (std::size_t i = 0; i < count; ++i) {
      detail::UnpackColumns unpack{bytes_.data() + i * size};
      std::uint64_t row = 0;
      unpack.one("row", "1", row);
      if (row != first + i + 1) {
        records.resize(i);
        break;
      }
      visit_columns(records[i], columns_, unpack);
    }
    return records;
  }

  /// Forgets trailing rows whose bytes never arrived; for a file whose writer was killed.
  void trim() {
    constexpr std::uint64_t kStep = kRowsPerChunk;
    while (rows_ > 0) {
      const std::uint64_t first = (rows_ - 1) / kStep * kStep;
      const std::uint64_t whole = read(first, rows_ - first).size();
      const bool all_there = first + whole == rows_;
      rows_ = first + whole;
      if (all_there || whole > 0) return;
    }
  }

  [[nodiscard]] bool close() { return dataset_.close(); }

 private:
  explicit RecordTable(const RecordColumns& columns) : columns_(columns) {
    const std::uint64_t row = 0;
    described_.one("row", "1", row);
    visit_columns(Record{}, columns_, described_);
    type_ = Hdf5Id(H5Tcreate(H5T_COMPOUND, described_.size), "row type");
    for (const auto& column : described_.columns) {
      const hsize_t shape[2] = {static_cast<hsize_t>(column.shape.first),
                                static_cast<hsize_t>(column.shape.second)};
      if (column.shape.first == 0) {
        require(H5Tinsert(type_, column.name, column.offset, column.element) >= 0, column.name);
      } else {
        const bool flat = column.shape.first == 1;
        const Hdf5Id array(H5Tarray_create2(column.element, flat ? 1 : 2, flat ? &shape[1] : shape),
                           column.name);
        require(H5Tinsert(type_, column.name, column.offset, array) >= 0, column.name);
      }
    }
  }

  [[nodiscard]] Hdf5Id select(hsize_t first, hsize_t count) const {
    Hdf5Id space(H5Dget_space(dataset_), "rows");
    require(H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, nullptr, &count, nullptr) >= 0,
            "select rows");
    return space;
  }

  RecordColumns columns_;
  detail::DescribeColumns described_;
  Hdf5Id type_;
  Hdf5Id dataset_;
  std::uint64_t rows_ = 0;
  std::vector<std::byte> bytes_;
};

}  // namespace tandem::recording
