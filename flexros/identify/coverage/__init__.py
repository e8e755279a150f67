"""Monte-Carlo check of an identification: do its intervals cover the truth, and how far off are its values?"""
