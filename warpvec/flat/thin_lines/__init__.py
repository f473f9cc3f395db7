"""Straight lines thinner than two pixels, such as staves, tables, graph paper and hatching, and what lies below."""
