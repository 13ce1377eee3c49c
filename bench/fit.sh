# Sourced: the power law through points.
# $1: file of rows that begin with robots; $2: column of the times; $3, $4: from and to so many
# robots. Exponent, and time of one robot.
power_law() {
  awk -v column="$2" -v from="$3" -v to="$4" '$1 >= from && $1 <= to { x = log($1); y = log($column); n++; sx += x; sy += y; sxx += x * x; sxy += x * y }
    END { if (n > 1) { b = (n * sxy - sx * sy) / (n * sxx - sx * sx); printf "%.2f %.6f\n", b, exp((sy - b * sx) / n) } }' "$1"
}
