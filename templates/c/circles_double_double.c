/* Sines and cosines of n angles. */
INLINE void circles(size_t n, const double_double *restrict x, double_double *restrict sine, double_double *restrict cosine)
{
    for (size_t i = 0; i < n; i++)
        pair_turn(x[i], &sine[i], &cosine[i]);
}
